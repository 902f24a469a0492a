"""Names that there are not, and values that are wrong: each marked line is an error of the type checker's."""

import clrt
import clrt.scene

hits = clrt.Tracer("showcase").intersect([0, 0, 5], [0, 0, -1])
print(clrt.rendr)  # WRONG
print(clrt.scene.Spere)  # WRONG
print(hits.shap)  # WRONG
print(hits.shape)
print(clrt.render("showcase").pixel)  # WRONG
print(clrt.read_image("a.png").layers)  # WRONG
clrt.Camera(orgin=[0, 0, 5])  # WRONG
clrt.Camera(fov="wide")  # WRONG
clrt.Camera(origin=3)  # WRONG
clrt.Scene(shpaes=[])  # WRONG
clrt.Scene(shapes=3)  # WRONG
clrt.scene.Sphere(center=[0, 0, 0], radus=1)  # WRONG
clrt.sweep("showcase", {"camera.fov": 3})  # WRONG
