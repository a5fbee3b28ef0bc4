# syntax=docker/dockerfile:1
# The service as a container: built with a toolchain, run on a small Debian without one.
#
#   docker build --build-arg CONTUSE_COMMIT=$(git rev-parse HEAD) -t contuse .    # recordings and reports state the commit
#   docker run --rm contuse token anna    # the line for the file tokens
#   docker run -p 8080:8080 -v contuse-data:/data -v ./tokens:/tokens:ro -e CONTUSE_TOKENS_FILE=/tokens contuse

FROM rust:1.95-slim-trixie AS build
RUN apt-get update \
    && apt-get install -y --no-install-recommends gcc libc6-dev \
    && rm -rf /var/lib/apt/lists/*
WORKDIR /src
COPY . .
ARG CONTUSE_COMMIT
# What was built before is kept between builds, and not in the image.
RUN --mount=type=cache,target=/usr/local/cargo/registry \
    --mount=type=cache,target=/src/target \
    cargo build --release --locked --features cluster --bin contuse \
    && strip --strip-debug -o /usr/local/bin/contuse target/release/contuse

FROM debian:trixie-slim
# The certificates of those who sign for databases and object stores.
RUN apt-get update \
    && apt-get install -y --no-install-recommends ca-certificates \
    && rm -rf /var/lib/apt/lists/*
RUN useradd --system --uid 10001 --no-create-home --shell /usr/sbin/nologin contuse \
    && install -d -o contuse -g contuse -m 0750 /data
COPY --from=build /usr/local/bin/contuse /usr/local/bin/contuse
COPY LICENSE-APACHE LICENSE-MIT /usr/share/doc/contuse/
USER 10001:10001
VOLUME /data
ENV CONTUSE_LISTEN=0.0.0.0:8080 CONTUSE_DATA=/data RUST_LOG=warn,contuse=info
EXPOSE 8080
# The binary asks itself: the image holds no curl.
HEALTHCHECK --interval=15s --timeout=5s --start-period=5s CMD ["contuse", "health"]
# On SIGTERM running jobs have CONTUSE_GRACE_S (20 s) to end before they go back into the queue: stop the container with
# a longer timeout than that (`docker stop --time 30`).
STOPSIGNAL SIGTERM
ENTRYPOINT ["contuse"]
CMD ["serve"]
