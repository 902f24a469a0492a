"use strict";
// The page works without this; with it the cases can be searched and their pictures looked at.

function open(details) {
  const data = details.querySelector(".pictures"), root = details.querySelector(".viewer");
  if (!details.open || !data || root.childElementCount) return;
  new Viewer(root, JSON.parse(data.textContent), details.querySelector(".name").textContent.trim().slice(1).trim());
}

const cases = [...document.querySelectorAll(".case")];
for (const details of cases) details.addEventListener("toggle", () => open(details));

const thumbs = new IntersectionObserver(entries => {
  for (const entry of entries.filter(entry => entry.isIntersecting)) {
    thumbs.unobserve(entry.target);
    const data = entry.target.closest(".case").querySelector(".pictures");
    if (data) entry.target.style.backgroundImage = `url(data:image/png;base64,${JSON.parse(data.textContent).ours})`;
  }
}, { rootMargin: "200px" });
for (const thumb of document.querySelectorAll(".thumb")) thumbs.observe(thumb);

const find = document.getElementById("find"), failed = document.getElementById("only-failed");
function filter() {
  const words = find.value.toLowerCase().split(/\s+/).filter(Boolean);
  let shown = 0;
  for (const details of cases) {
    const text = details.dataset.words.toLowerCase();
    details.hidden = (failed.checked && details.dataset.failed === "0") || !words.every(word => text.includes(word));
    shown += !details.hidden;
  }
  document.getElementById("shown").textContent = `${shown} of ${cases.length} cases`;
}
find.addEventListener("input", filter);
failed.addEventListener("change", filter);
document.getElementById("filter").addEventListener("submit", event => event.preventDefault());
filter();

function follow() {
  const target = document.getElementById(location.hash.slice(1));
  if (target instanceof HTMLDetailsElement) {
    target.hidden = false;
    target.open = true;
    target.scrollIntoView();
  }
}
addEventListener("hashchange", follow);
follow();
