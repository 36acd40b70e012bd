#!/usr/bin/env bash
# Bundles what the pages use of other people's work into static/vendor: needs node and npm.
# Run it after a change of package.json; what it writes is committed, node_modules is not.
set -euo pipefail
cd "$(dirname "$0")"
to=../static/vendor

npm ci --ignore-scripts
mkdir -p "$to"
npx --no-install esbuild node_modules/uplot/dist/uPlot.esm.js \
  --bundle --minify --format=esm --target=es2022 --legal-comments=none --outfile="$to/uplot.js"
cp node_modules/uplot/dist/uPlot.min.css "$to/uplot.css"
cp node_modules/uplot/LICENSE "$to/uplot.LICENSE"

# name, version and hash of each, so that a test can tell what was changed by hand
version=$(node -p "require('./node_modules/uplot/package.json').version")
(cd "$to" && sha256sum uplot.css uplot.js uplot.LICENSE | sed "s/\$/  uplot $version/" > VERSIONS)
