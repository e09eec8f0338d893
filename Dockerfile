# docker build -t gridbloom . && docker run --rm -p 8000:8000 -v gridbloom:/data gridbloom
# The address with its token is printed at the start; GRIDBLOOM_TOKEN sets a token of your own.

ARG PYTHON=3.11
# What the image is made on: a Debian with this Python.
ARG BASE=python:${PYTHON}-slim

# The wheel, with the pages in it. Node comes with the wheel's build requirements. All packages have the versions and
# hashes of requirements/, as in the tests.
FROM ${BASE} AS wheel
WORKDIR /src
COPY requirements/build.txt requirements/
RUN pip install --no-cache-dir --require-hashes --requirement requirements/build.txt
COPY pyproject.toml README.md CHANGELOG.md LICENSE ./
COPY static static
COPY mapper mapper
COPY server server
RUN pip wheel --no-cache-dir --no-deps --no-build-isolation --wheel-dir /wheels .

# The service and its dependencies in an environment of their own, without what it does not use: pip; packages' tests,
# headers and stubs of types; the parts of SciPy, NumPy and SQLAlchemy that none of its modules imports, and zstandard's
# for PyPy; Pillow's AVIF; bytecode of modules that are never imported; what linkers and debuggers read of extension
# modules. strip damages files that were rewritten when their wheel was made: libraries below *.libs, and numba's thread
# pools, are left as they are, and all others are loaded once. import_all.py fails where something that is used was
# removed. Licences stay.
FROM ${BASE} AS environment
RUN apt-get update && apt-get install --yes --no-install-recommends binutils libpango-1.0-0 libpangoft2-1.0-0 \
        libharfbuzz-subset0 && rm -r /var/lib/apt/lists
COPY requirements/runtime.txt requirements/
RUN python -m venv --without-pip /opt/gridbloom \
    && pip --python /opt/gridbloom/bin/python install --no-cache-dir --no-compile --require-hashes \
        --requirement requirements/runtime.txt \
    && cd /opt/gridbloom/lib/python3*/site-packages \
    && for part in cluster datasets differentiate fft fftpack integrate interpolate io misc odr optimize signal stats; \
        do rm -r scipy/$part; done \
    && rm -r numpy/distutils sqlalchemy/testing scipy/special/cython_special.*.so zstandard/_cffi.*.so PIL/_avif.*.so \
        pillow.libs/libavif-*.so* \
    && find . -type d -name tests -prune -exec rm -r {} + \
    && find . -type f '(' -name '*.pyi' -o -name '*.pxd' -o -name '*.pyx' -o -name '*.h' -o -name '*.a' ')' -delete \
    && find . -type f -name '*.so' -not -path '*.libs/*' -not -path '*/numba/np/ufunc/*' \
        -exec strip --strip-unneeded {} + \
        -exec /opt/gridbloom/bin/python -B -c "import ctypes, sys; [ctypes.CDLL(path) for path in sys.argv[1:]]" {} +
COPY deploy/import_all.py deploy/
RUN --mount=type=bind,from=wheel,source=/wheels,target=/wheels \
    pip --python /opt/gridbloom/bin/python install --no-cache-dir --no-compile --no-deps /wheels/gridbloom-*.whl \
    && PYTHONDONTWRITEBYTECODE= /opt/gridbloom/bin/python deploy/import_all.py

# What runs: no compiler, no Node. Pango and a font are for reports as PDF.
FROM ${BASE} AS runtime
RUN apt-get update && apt-get install --yes --no-install-recommends libpango-1.0-0 libpangoft2-1.0-0 \
        libharfbuzz-subset0 fonts-dejavu-core && rm -r /var/lib/apt/lists
RUN useradd --system --create-home --uid 10001 gridbloom \
    && install --directory --owner gridbloom --group gridbloom /data /blobs /var/cache/gridbloom
COPY --from=environment /opt/gridbloom /opt/gridbloom
ENV VIRTUAL_ENV=/opt/gridbloom \
    PATH=/opt/gridbloom/bin:$PATH \
    PYTHONUNBUFFERED=1 \
    NUMBA_CACHE_DIR=/var/cache/gridbloom \
    GRIDBLOOM_PORT=8000 \
    GRIDBLOOM_LOG_FORMAT=json
USER gridbloom
WORKDIR /data
# Compiles every kernel. On a processor of another kind than the builder's numba compiles them again at first use.
RUN python -m mapper.tools.precompile
VOLUME /data
EXPOSE 8000
HEALTHCHECK --interval=30s --timeout=5s --start-period=20s --retries=3 CMD ["python", "-c", \
    "import os, urllib.request; urllib.request.urlopen(f'http://127.0.0.1:{os.environ[\"GRIDBLOOM_PORT\"]}/livez', timeout=4)"]
CMD ["gridbloom", "serve", "--host", "0.0.0.0", "--data-dir", "/data"]
