// Runs phynness_loop in WebAssembly against a spring of 600 N/m: the device stands 10 mm from rest, and the force must
// be that of spring and coupling (400 N/m) in series.
// Usage: node check_loop.mjs loop.wasm
import { check, load } from './module.mjs';

const { f, take, view } = load(process.argv[2]);
// Offsets of phynness_loop.h, which holds doubles only: two, and a frame of fourteen before the coupling.
const coupling = 8 * (2 + 9 + 3 + 2), allowance = coupling + 8 * 6, tripFrozen = coupling + 8 * 16;
const settings = take(512), size = take(4), handle = take(4);
check(f.phn_loop_defaults(settings), 'phn_loop_defaults');
const setting = (offset) => view(Float64Array, settings + offset, 1);
if (setting(coupling)[0] !== 400 || setting(allowance)[0] !== 2e-5 || setting(tripFrozen)[0] !== 0.05)
  throw new Error('phn_loop_settings has another layout');
setting(allowance)[0] = 1e3;  // no passivity controller
setting(tripFrozen)[0] = 0;  // this device does not move while it is held
check(f.phn_loop_size(size), 'phn_loop_size');
const n = view(Uint32Array, size, 1)[0];
check(f.phn_loop_init(take(n), n, settings, handle), 'phn_loop_init');
const loop = view(Uint32Array, handle, 1)[0];
check(f.phn_loop_engage(loop), 'phn_loop_engage');
const position = take(24), tool = take(24), response = take(144), force = take(24);
for (let i = 1; i <= 400; ++i) {
  view(Float64Array, position, 3).set([0.006, 0, -0.008]);
  check(f.phn_loop_read(loop, position, 1e-3 * i, 1e-3 * i, tool), 'phn_loop_read');
  const at = Array.from(view(Float64Array, tool, 3));
  view(Int32Array, response, 3).set([0, 1, 1]);
  view(Float64Array, response + 16, 16)
    .set([...at.map((x) => 600 * x), 600, 0, 0, 0, 600, 0, 0, 0, 600, ...at, -1]);
  check(f.phn_loop_hold(loop, response, 1e-3 * i, force), 'phn_loop_hold');
}
const held = Math.hypot(...view(Float64Array, force, 3)), expected = 0.01 / (1 / 600 + 1 / 400);
console.log(`loop_force ${held}, expected ${expected}`);
process.exit(Math.abs(held - expected) < 1e-9 * expected ? 0 : 1);
