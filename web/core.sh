#!/bin/sh
# Builds crates/bsdftree-wasm into web/src/core.wasm; `core.sh --can` only tells whether it could.
#
# Where rustup has its target (`rustup target add wasm32-unknown-unknown`) by cargo alone. Else by Debian's compiler and the source of its
# standard library (`apt-get install rustc-web rust-web-src`), with cargo and the linker of the toolchain that is there.
set -eu
cd "$(dirname "$0")/.."
target=wasm32-unknown-unknown
sysroot=$(rustc --print sysroot)
debian=${DEBIAN_RUSTC:-/usr/bin/rustc}
export CARGO_TARGET_WASM32_UNKNOWN_UNKNOWN_RUSTFLAGS="-C target-feature=+simd128"

if [ -d "$sysroot/lib/rustlib/$target" ]; then
	by=rustup
elif [ -x "$debian" ] && [ -d "$("$debian" --print sysroot)/lib/rustlib/src/rust/library" ]; then
	by=debian
else
	echo "there is no standard library for $target: run 'rustup target add $target'," >&2
	echo "or, where rustup cannot fetch it, 'apt-get install rustc-web rust-web-src'" >&2
	exit 1
fi
[ "${1:-}" != --can ] || exit 0

if [ $by = rustup ]; then
	cargo build --quiet --locked --profile wasm --target "$target" -p bsdftree-wasm
else
	linker=$(ls "$sysroot"/lib/rustlib/*/bin/rust-lld | head -n 1)
	RUSTC=$debian RUSTC_BOOTSTRAP=1 CARGO_TARGET_WASM32_UNKNOWN_UNKNOWN_LINKER=$linker \
		cargo build --quiet --locked -Zbuild-std=std,panic_abort --profile wasm --target "$target" -p bsdftree-wasm
fi
cp "${CARGO_TARGET_DIR:-target}/$target/wasm/bsdftree_wasm.wasm" web/src/core.wasm
ls -l web/src/core.wasm
