"""Programs for developers and images: benchmarks, ahead-of-time compilation of the kernels."""
