"""OpenCL: drivers, their choice, compiled kernels, and what passes run on."""
