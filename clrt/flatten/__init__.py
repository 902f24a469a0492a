"""From a scene to the arrays that go to the device, in float64, rounded once. Knows no OpenCL."""
