// Compares the responses of both modules to golden queries: the runtime with the host in double, the image bit for bit.
// Usage: node check.mjs phynness.wasm MODEL_DIR/model.txt force.wasm EXPORTED/model.bin golden.json
//        (EXPORTED and golden.json by phynness export MODEL_DIR -o EXPORTED --float --golden 256 --json golden.json)
import { readFileSync } from 'node:fs';
import { load, loadImage, loadModel } from './module.mjs';

const [runtimeFile, modelFile, forceFile, imageFile, goldenFile] = process.argv.slice(2);
if (goldenFile === undefined) {
  console.error('usage: node check.mjs phynness.wasm model.txt force.wasm model.bin golden.json');
  process.exit(2);
}
const golden = JSON.parse(readFileSync(goldenFile, 'utf8')).golden;
const runtime = load(runtimeFile), forces = load(forceFile);
const model = loadModel(runtime, readFileSync(modelFile)), image = loadImage(forces, readFileSync(imageFile));

class Deviation {
  largest = 0;
  difference = 0;
  add(expected, got) {
    for (let k = 0; k < 3; ++k) {
      this.largest = Math.max(this.largest, Math.abs(expected[k]));
      this.difference = Math.max(this.difference, Math.abs(expected[k] - got[k]));
      if (!Number.isFinite(got[k])) this.difference = Infinity;
    }
  }
  get relative() {
    return this.largest > 0 ? this.difference / this.largest : this.difference;
  }
}

const force = new Deviation(), deformation = new Deviation();
let otherBits = 0, otherStatuses = 0;
const at = (field, output) => field.slice(3 * output, 3 * output + 3);
const count = (expected, got) => {
  for (let k = 0; k < 3; ++k) if (expected[k] !== got[k]) ++otherBits;
};
for (const q of golden) {
  force.add(q.force, model.force(q.node, q.displacement).force);
  const answer = image.force(q.node, q.displacement);
  count(q.image_force, answer.force);
  if (answer.status !== q.status) ++otherStatuses;
  if (image.nOutput > 0) {
    deformation.add(q.deformation, at(model.deform(q.node, q.displacement), q.output));
    count(q.image_deformation, at(image.deform(q.node, q.displacement), q.output));
  }
}
console.log(`queries ${golden.length}`);
console.log(`module_bytes ${runtime.bytes}`);
console.log(`force_module_bytes ${forces.bytes}`);
console.log(`force_deviation ${force.relative}`);
console.log(`deformation_deviation ${deformation.relative}`);
console.log(`image_other_bits ${otherBits}`);
console.log(`image_other_statuses ${otherStatuses}`);
// The exp of the C library differs in its last bit, and weights cancel.
const good = golden.length > 0 && force.relative < 1e-10 && deformation.relative < 1e-10 && otherBits === 0 && otherStatuses === 0;
console.log(`agree ${good ? 1 : 0}`);
process.exit(good ? 0 : 1);
