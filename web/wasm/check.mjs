// Compares the responses of an image of floats to golden queries, bit for bit.
// Usage: node check.mjs force.wasm EXPORTED/model.bin golden.json
//        (EXPORTED and golden.json by phynness export MODEL_DIR -o EXPORTED --float --golden 256 --json golden.json)
import { readFileSync } from 'node:fs';
import { check, load } from './module.mjs';

const [moduleFile, imageFile, goldenFile] = process.argv.slice(2), { f, take, view, put } = load(moduleFile);
const { golden } = JSON.parse(readFileSync(goldenFile, 'utf8')), bytes = readFileSync(imageFile), handle = take(4);
check(f.phn_imagef_open(put(bytes), bytes.byteLength, handle), 'phn_imagef_open');
const image = view(Uint32Array, handle, 1)[0], nOutput = f.phn_imagef_n_output(image);
const d = take(12), force = take(12), scratch = take(f.phn_imagef_scratch_size(image)), field = take(12 * nOutput);
let otherBits = 0, otherStatuses = 0;
const count = (expected, at) => view(Float32Array, at, 3).forEach((x, k) => (otherBits += x !== expected[k]));
for (const q of golden) {
  view(Float32Array, d, 3).set(q.displacement);
  otherStatuses += f.phn_imagef_force(image, q.node, d, force) !== q.status;
  count(q.image_force, force);
  if (nOutput === 0) continue;
  check(f.phn_imagef_deform(image, scratch, q.node, d, field), 'phn_imagef_deform');
  count(q.image_deformation, field + 12 * q.output);
}
console.log(`queries ${golden.length}, other bits ${otherBits}, other statuses ${otherStatuses}`);
process.exit(golden.length > 0 && otherBits === 0 && otherStatuses === 0 ? 0 : 1);
