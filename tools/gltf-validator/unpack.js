// Writes the views of FILE.glb that are compressed, as meshoptimizer's own decoder reads them, to the
// buffer that they stand for: node unpack.js FILE.glb OUT.bin
const fs = require("fs");
const MeshoptDecoder = require("./node_modules/meshoptimizer/meshopt_decoder.cjs");

const NAME = "EXT_meshopt_compression";
const [file, out] = process.argv.slice(2);
const data = fs.readFileSync(file);
const length = data.readUInt32LE(12);
const content = JSON.parse(data.subarray(20, 20 + length).toString());
const binary = data.subarray(28 + length);
MeshoptDecoder.ready.then(() => {
  const whole = Buffer.alloc(content.buffers[1].byteLength);
  for (const view of content.bufferViews) {
    const packed = view.extensions && view.extensions[NAME];
    if (!packed) continue;
    const source = binary.subarray(packed.byteOffset, packed.byteOffset + packed.byteLength);
    const target = new Uint8Array(packed.count * packed.byteStride);
    const { count, byteStride, mode, filter } = packed;
    MeshoptDecoder.decodeGltfBuffer(target, count, byteStride, source, mode, filter);
    whole.set(target, view.byteOffset);
  }
  fs.writeFileSync(out, whole);
});
