// node draft_freesewing.mjs MEASUREMENTS.freesewing.json: drafts a design of ours with FreeSewing's core from the file and
// prints, as JSON, the lengths of its paths (mm), the slope of its shoulder line (degrees), and what went wrong.
import { readFileSync } from "node:fs";
import { Design } from "@freesewing/core";

const girths = ["waist", "seat", "chest"];
const measurements = JSON.parse(readFileSync(process.argv[2], "utf8"));
const given = girths.filter((name) => name in measurements);

// Half of each girth on the straight, at heights one under the other; a shoulder line at the shoulders' slope if it is given.
const block = {
  name: "annulus.block",
  measurements: given,
  optionalMeasurements: ["shoulderSlope"],
  draft: ({ Path, Point, paths, points, measurements: body, part }) => {
    given.forEach((name, row) => {
      points[name] = new Point(0, 200 * row);
      paths[name] = new Path().move(points[name]).line(points[name].shift(0, body[name] / 2));
    });
    if (body.shoulderSlope) {
      points.neck = new Point(0, -100);
      paths.shoulder = new Path().move(points.neck).line(points.neck.shift(-body.shoulderSlope, 130));
    }
    return part;
  },
};

const design = new Design({ data: { name: "annulus-block", version: "1.0.0" }, parts: [block] });
const pattern = new design({ measurements, sa: 0 }).draft();
const { paths } = pattern.parts[0]["annulus.block"];
const lengths = Object.fromEntries(given.map((name) => [name, paths[name].length()]));
const shoulder = paths.shoulder?.ops;
const slope = shoulder ? (360 - shoulder[0].to.angle(shoulder[1].to)) % 360 : null;
console.log(JSON.stringify({ lengths, slope_deg: slope, errors: pattern.setStores[0].logs.error.map(String) }));
