#!/usr/bin/env bash
# Bundles the script of the report, web/dist/report.js, which is committed. With --check it fails where that file is not
# what the sources give. Needs Node and, for its packages, the npm registry.
set -euo pipefail
cd "$(dirname "$0")"

out=dist/report.js
if [ "${1:-}" = --check ]; then
  out=$(mktemp -d)/report.js
  trap 'rm -rf "$(dirname "$out")"' EXIT
fi
if [ ! -d node_modules ] || [ package-lock.json -nt node_modules ]; then
  npm ci --no-audit --no-fund --loglevel=error >&2
  touch node_modules
fi
# three.js' notice of copyright stays in; </script> inside a string would end the element that holds the script.
node_modules/.bin/esbuild src/main.js --bundle --minify --format=iife --target=es2022 \
  --legal-comments=inline --charset=ascii --log-level=warning --outfile="$out"
if grep -qi '</script\|<!--' "$out"; then
  echo "$out holds what would end or hide its script element" >&2
  exit 1
fi
if [ "${1:-}" = --check ] && ! cmp -s "$out" dist/report.js; then
  echo "web/dist/report.js is not what web/src gives: run web/build.sh and commit it" >&2
  exit 1
fi
