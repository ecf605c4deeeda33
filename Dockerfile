# taxel as an image: docker build --tag taxel . && docker run --rm --volume "$PWD:/data" taxel run recordings.npz
# A robot's small program: docker build --build-arg FEATURES=runtime --build-arg PROFILE=robot --tag taxel-robot .
FROM rust:1-slim-bookworm AS build
ARG FEATURES="lab serial"
ARG PROFILE=release
WORKDIR /taxel
COPY . .
RUN cargo build --locked --package taxel --no-default-features --features "$FEATURES" --profile "$PROFILE" \
    && cp "target/$PROFILE/taxel" /usr/local/bin/taxel

FROM debian:bookworm-slim
COPY --from=build /usr/local/bin/taxel /usr/local/bin/taxel
COPY --from=build /taxel/LICENSE-MIT /taxel/LICENSE-APACHE /usr/share/doc/taxel/
# Not root: files in a mounted folder belong to this user, or to the one that --user names.
RUN useradd --create-home --uid 1000 taxel
USER taxel
WORKDIR /data
ENTRYPOINT ["taxel"]
CMD ["--help"]
