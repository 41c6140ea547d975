#!/usr/bin/env bash
# Draws the contact sheet of the paper's examples 1-6 on two simulated heads: make-sheet.sh ANNULUS FOLDER
set -euo pipefail
annulus=$(readlink -f "$1")
mkdir -p "$2"
cp "$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")"/*.json "$2"
cd "$2"

# The two heads: the booth's own, and that of the standing person.
for subject in head body; do
  printf '[sim]\nsubject = "%s"\nseed = 4\n' "$subject" >"$subject.toml"
  "$annulus" scan --config "$subject.toml" --profile head --out "$subject.mcap" --force
done
"$annulus" fit head.mcap --out head.json
"$annulus" fit body.mcap --out person.json

# The frames: the paper's shapes, told apart by their rims.
"$annulus" glasses design --style example4 --out frame1-2.json
"$annulus" glasses design --style example3 --upper-thickness 9% --lower-thickness 7% --out frame3.json
"$annulus" glasses design --style example4 --upper-thickness 15% --lower-thickness 5% --out frame4.json
"$annulus" glasses design --style example2 --upper-thickness 8% --lower-thickness 7% --out frame5.json
"$annulus" glasses design --style example1 --height 62% --bridge-height 26 --upper-thickness 9% --lower-thickness 7% \
  --out frame6.json

# Put on by the paper's four steps.
for head in head person; do
  for k in 1-2 3 4 5 6; do
    "$annulus" glasses fit "$head.json" --frame "frame$k.json" --placement paper --out "$head$k.json" >/dev/null
  done
done
"$annulus" render --batch contact-sheet.json
