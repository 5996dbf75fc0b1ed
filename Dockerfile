# Two images from the sources in this folder:
#
#     docker build -t sheetlight .                              # `gen` alone, without a shell
#     docker build -t sheetlight-scale --target scale .         # Python with the package: the tasks of python/examples/cluster
#
#     docker run --rm --user "$(id -u):$(id -g)" -v "$PWD:/data" sheetlight --recipe wood-small --n 16 --out planks
#
# Neither runs as root; both take a read-only root file system and write only to the folders that are mounted. Exit statuses are
# those of the program. `gen check` needs the library onnxruntime, which the second image alone can hold:
# `--build-arg PACKAGES=onnxruntime`.

# What they are made from is named by digest, so that the same sources make the same image; .github/renovate.json renews digests.
FROM rust:1.95-slim-bookworm@sha256:d7482085ff5b415f84dba5647ae71606650bdef00db7aeb69f4b3d170c3e4082 AS build
WORKDIR /src
COPY . .
RUN --mount=type=cache,target=/usr/local/cargo/registry \
    --mount=type=cache,target=/src/target,sharing=locked \
    cargo build --profile dist --locked --bin gen && cp target/dist/gen /usr/local/bin/gen
# An empty folder that belongs to the user of the images.
RUN mkdir /data && chown 65532:65532 /data

FROM python:3.13-slim-bookworm@sha256:67a1e1f215ccda113cfc024e8639049257e88f273898f595b61476d128d387e8 AS python

FROM python AS wheel
COPY --from=build /usr/local/cargo /usr/local/cargo
COPY --from=build /usr/local/rustup /usr/local/rustup
ENV PATH=/usr/local/cargo/bin:$PATH RUSTUP_HOME=/usr/local/rustup CARGO_HOME=/usr/local/cargo
# Debian keeps one version of these at a time, and nothing of them is in the image.
# hadolint ignore=DL3008
RUN apt-get update \
    && apt-get install --yes --no-install-recommends gcc libc6-dev \
    && rm -rf /var/lib/apt/lists/*
WORKDIR /src
COPY . .
RUN --mount=type=cache,target=/usr/local/cargo/registry \
    --mount=type=cache,target=/src/target,sharing=locked \
    --mount=type=cache,target=/root/.cache/pip \
    pip wheel --no-deps --wheel-dir /wheels .

FROM python AS scale
# Extras of the package, and packages beside it.
ARG EXTRAS=s3
ARG PACKAGES=""
COPY --from=wheel /wheels /wheels
# The wheel is the one file there; what it needs has the bounds that it names.
# hadolint ignore=DL3013
RUN --mount=type=cache,target=/root/.cache/pip \
    wheel=$(echo /wheels/sheetlight-*.whl) \
    && pip install "${wheel}[${EXTRAS}]" ${PACKAGES} \
    && rm -r /wheels
COPY --from=build --chown=65532:65532 /data /data
USER 65532:65532
WORKDIR /data
CMD ["python", "-m", "sheetlight.scale", "--help"]

FROM gcr.io/distroless/cc-debian12:nonroot@sha256:66aa873a4a14fb164aa01296058efd8253744606d72715e45acface073359faa AS gen
LABEL org.opencontainers.image.title="Sheetlight" \
      org.opencontainers.image.description="Simulator of laser triangulation with subsurface scattering, and a dataset factory around it" \
      org.opencontainers.image.licenses="MIT OR Apache-2.0"
COPY --from=build /usr/local/bin/gen /usr/local/bin/gen
COPY --from=build --chown=65532:65532 /data /data
USER 65532:65532
WORKDIR /data
# Process 1 of a container has no other way to hear of its end: this is Ctrl-C.
STOPSIGNAL SIGINT
ENTRYPOINT ["/usr/local/bin/gen"]
CMD ["--help"]
