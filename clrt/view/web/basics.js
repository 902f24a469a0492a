// Looks at a scene: clrt view's page and the notebook's widget. Texts of scenes are only ever texts here.

// --- elements

const make = (tag, properties = {}, ...children) => {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(properties)) {
    if (name in element) element[name] = value;
    else element.setAttribute(name, value);
  }
  element.append(...children);
  return element;
};

const button = (text, act, properties = {}) => {
  const element = make("button", { type: "button", ...properties }, text);
  element.addEventListener("click", act);
  return element;
};

const labelled = (text, control) => make("label", {}, make("span", {}, text), control);

const select = (groups, value, act) => {
  const element = make("select");
  for (const { group, names } of groups) {
    const options = names.map(name => make("option", { value: name.value ?? name }, String(name.text ?? name)));
    if (group) element.append(make("optgroup", { label: group }, ...options));
    else element.append(...options);
  }
  element.value = value;
  element.addEventListener("change", () => act(element.value));
  return element;
};

const download = ({ name, type }, bytes) => {
  const address = URL.createObjectURL(new Blob([bytes], { type }));
  make("a", { href: address, download: name }).click();
  setTimeout(() => URL.revokeObjectURL(address), 60000);
};

// --- questions: ask(kind, body) gives [table, bytes], and fails with what is wrong

class Refused extends Error {}

const checked = (table, bytes) => {
  if (table.error) throw new Refused(table.error);
  return [table, bytes];
};

class OverHttp {
  async ask(kind, body) {
    let answer;
    try {
      answer = await fetch(kind, {
        method: "POST", body: JSON.stringify(body), headers: { "Content-Type": "application/json" },
        referrerPolicy: "no-referrer", credentials: "omit", cache: "no-store",
      });
    } catch {
      throw new Refused("clrt view has ended; start it again");
    }
    if (!answer.ok) throw new Refused(`clrt view refused it (${answer.status})`);
    const data = await answer.arrayBuffer();
    const end = 4 + new DataView(data).getUint32(0, true);
    return checked(JSON.parse(new TextDecoder().decode(data.slice(4, end))), data.slice(end));
  }
}

class OverModel {
  constructor(model) {
    this.model = model;
    this.waiting = new Map();
    this.count = 0;
    this.heard = (message, buffers) => {
      const wait = this.waiting.get(message.id);
      if (!wait) return; // another view's
      this.waiting.delete(message.id);
      const part = buffers?.[0];
      const bytes = part ? new Uint8Array(part.buffer ?? part, part.byteOffset ?? 0, part.byteLength).slice().buffer
        : new ArrayBuffer(0);
      try {
        wait.resolve(checked(message.table, bytes));
      } catch (fault) {
        wait.reject(fault);
      }
    };
    model.on("msg:custom", this.heard);
    this.name = crypto.getRandomValues(new Uint32Array(2)).join("-");
  }

  ask(kind, body) {
    const id = `${this.name}:${this.count++}`;
    return new Promise((resolve, reject) => {
      this.waiting.set(id, { resolve, reject });
      this.model.send({ id, kind, body });
    });
  }

  close() {
    this.model.off?.("msg:custom", this.heard);
  }
}
