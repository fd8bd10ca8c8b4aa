// Prints what the Khronos glTF validator says of FILE, as JSON: node validate.js FILE.glb
const fs = require("fs");
const path = require("path");
const { validateBytes } = require("gltf-validator");

const file = process.argv[2];
validateBytes(new Uint8Array(fs.readFileSync(file)), {
  uri: path.basename(file),
  maxIssues: 0, // all of them
  writeTimestamp: false,
  externalResourceFunction: async (uri) =>
    new Uint8Array(fs.readFileSync(path.join(path.dirname(file), decodeURIComponent(uri)))),
}).then(
  (report) => console.log(JSON.stringify(report, null, 2)),
  (fault) => {
    console.error(String(fault));
    process.exit(1);
  },
);
