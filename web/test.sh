#!/bin/sh
# Builds the viewer and tests it in a browser where all that this needs is there; else says in one line what is missing.
set -eu
cd "$(dirname "$0")/.."

missing() {
	echo "SKIPPED: the viewer in a browser: $1" >&2
	exit 0
}

node -e 'const [a, b] = process.versions.node.split("."); process.exit(a > 20 || (a == 20 && b >= 19) ? 0 : 1)' 2>/dev/null ||
	missing "no node 20.19 or newer (apt-get install nodejs npm)"
command -v npm >/dev/null || missing "no npm (apt-get install npm)"
command -v "${CHROMIUM:-/usr/bin/chromium}" >/dev/null || missing "no Chromium (apt-get install chromium, or CHROMIUM=…)"
reason=$(web/core.sh --can 2>&1) || missing "$(echo "$reason" | tr '\n' ' ')"
[ -d web/node_modules ] || make --no-print-directory web/node_modules ||
	missing "npm cannot fetch what web/package-lock.json lists"
make --no-print-directory web
cd web
exec npm run --silent test
