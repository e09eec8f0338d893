"""Programs for developers and images: benchmarks, compiling the kernels ahead of time."""
