#!/usr/bin/env bash
# Bundles what the pages use of other people's work into static/vendor: needs node and npm.
# Run it after a change of package.json; what it writes is committed, node_modules is not.
set -euo pipefail
cd "$(dirname "$0")"
to=../static/vendor

bundle() { # entry, name
  npx --no-install esbuild "$1" \
    --bundle --minify --format=esm --target=es2022 --legal-comments=none --outfile="$to/$2.js"
}
list() { # package, files: name, version and hash of each, so that a test can tell what was changed by hand
  local version
  version=$(node -p "require('./node_modules/$1/package.json').version")
  (cd "$to" && sha256sum "${@:2}" | sed "s/\$/  $1 $version/")
}

npm ci --ignore-scripts
mkdir -p "$to"
bundle node_modules/uplot/dist/uPlot.esm.js uplot
cp node_modules/uplot/dist/uPlot.min.css "$to/uplot.css"
cp node_modules/uplot/LICENSE "$to/uplot.LICENSE"
bundle three.js three
cp node_modules/three/LICENSE "$to/three.LICENSE"
{
  list three three.js three.LICENSE
  list uplot uplot.css uplot.js uplot.LICENSE
} > "$to/VERSIONS"
