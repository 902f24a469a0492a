"""The float32 twin: what the kernels compute, in numpy, bit for bit."""
