"""A scene that is looked at: pictures that follow the camera and sliders, in a browser or a notebook."""
