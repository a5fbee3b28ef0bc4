# The service as a container: built with the toolchain of the project, run on a small Debian without one.
#
#   docker build -t contuse .
#   docker run -p 8080:8080 -v contuse-data:/data contuse

FROM rust:1.95-slim-trixie AS build
RUN apt-get update \
    && apt-get install -y --no-install-recommends gcc libc6-dev \
    && rm -rf /var/lib/apt/lists/*
WORKDIR /src
# Dependencies first: they are built again only when they change, not with every line of the sources.
COPY Cargo.toml Cargo.lock ./
RUN mkdir -p src benches \
    && echo '//! placeholder' > src/lib.rs \
    && echo 'fn main() {}' | tee src/main.rs benches/element_kernels.rs > benches/scenes.rs \
    && cargo build --release --locked --bin contuse \
    && rm -rf src benches target/release/.fingerprint/contuse-* target/release/deps/*contuse-*
COPY . .
RUN cargo build --release --locked --bin contuse \
    && strip --strip-debug target/release/contuse

FROM debian:trixie-slim
RUN useradd --system --uid 10001 --no-create-home --shell /usr/sbin/nologin contuse \
    && install -d -o contuse -g contuse -m 0750 /data
COPY --from=build /src/target/release/contuse /usr/local/bin/contuse
COPY --from=build /src/LICENSE-APACHE /src/LICENSE-MIT /usr/share/doc/contuse/
USER 10001:10001
VOLUME /data
ENV CONTUSE_LISTEN=0.0.0.0:8080 CONTUSE_DATA=/data RUST_LOG=warn,contuse=info
EXPOSE 8080
# The binary asks itself: the image holds no curl.
HEALTHCHECK --interval=15s --timeout=5s --start-period=5s CMD ["contuse", "health"]
# SIGTERM finishes what runs within the grace or puts it back into the queue; give the container longer than that.
STOPSIGNAL SIGTERM
ENTRYPOINT ["contuse"]
CMD ["serve"]
