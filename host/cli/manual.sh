#!/bin/sh
# manual.sh PROGRAM FOLDER: writes the manual pages brdfit.1 and brdfit-COMMAND.1 from what PROGRAM --help says.
# Needs help2man.
set -eu
program=$1 folder=$2
mkdir -p "$folder"
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
version=$("$program" --version)

# page NAME SUMMARY COMMAND...: through a program of the page's name.
page() {
    name=$1 summary=$2
    shift 2
    printf '#!/bin/sh\nexec "%s" %s "$@"\n' "$program" "$*" >"$scratch/$name"
    chmod +x "$scratch/$name"
    help2man --no-info --manual "brdfit" --name "$summary" --version-string "$version" \
        --output "$folder/$name.1" "$scratch/$name"
}

page brdfit "evaluates BRDF models and fits them to measured reflectance"
"$program" --help | sed -n '/^Subcommands:/,/^$/s/^  \([a-z][a-z-]*\)  */\1 /p' |
    while read -r command summary; do
        page "brdfit-$command" "$summary" "$command"
    done
for command in $("$program" bench --help 2>/dev/null | sed -n '/^Subcommands:/,/^$/s/^  \([a-z][a-z-]*\) .*/\1/p'); do
    page "brdfit-bench-$command" "bench $command of brdfit" bench "$command"
done
