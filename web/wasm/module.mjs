// A minimal interface to a module. It allocates memory after that of the module and never frees it.
import { readFileSync } from 'node:fs';

export function load(file) {
  const bytes = readFileSync(file);
  const { exports } = new WebAssembly.Instance(new WebAssembly.Module(bytes), {});
  exports.__wasm_call_ctors();
  let top = exports.__heap_base.value;
  // Address of n bytes, aligned to 16.
  const take = (n) => {
    const at = (top + 15) & ~15;
    top = at + n;
    const missing = top - exports.memory.buffer.byteLength;
    if (missing > 0) exports.memory.grow(Math.ceil(missing / 65536));
    return at;
  };
  // A typed array over memory. Make a new one after every take(), which may move all memory.
  const view = (Type, at, n) => new Type(exports.memory.buffer, at, n);
  const put = (data) => {
    const at = take(data.byteLength);
    new Uint8Array(exports.memory.buffer, at, data.byteLength).set(
      new Uint8Array(data.buffer, data.byteOffset, data.byteLength));
    return at;
  };
  return { f: exports, take, view, put, bytes: bytes.length };
}

export function check(status, what) {
  if (status < 0) throw new Error(`${what}: status ${status}`);
  return status;
}

// phn_info in 32-bit memory: words before its numbers (three texts and a gap, a double of two words, six lists and
// twice eight texts of fields), then numbers: nodes, active, output ...; less than infoBytes with its provenance.
const infoNumbers = 3 + 1 + 2 + 6 + 2 * 8, infoBytes = 256;

// Loads model.txt into the whole runtime.
export function loadModel(wasm, text) {
  const { f, take, view, put } = wasm;
  const at = put(text), size = take(4), handle = take(4);
  const number = (address) => view(Uint32Array, address, 1)[0];
  check(f.phn_model_size(at, text.byteLength, size, 0), 'phn_model_size');
  const modelBytes = number(size);
  check(f.phn_model_init(take(modelBytes), modelBytes, at, text.byteLength, handle, 0), 'phn_model_init');
  const model = number(handle);
  check(f.phn_data_size(model, 1, size), 'phn_data_size');
  const dataBytes = number(size);
  check(f.phn_data_init(take(dataBytes), dataBytes, model, 1, handle), 'phn_data_init');
  const data = number(handle), info = take(infoBytes);
  check(f.phn_model_info(model, info), 'phn_model_info');
  const nOutput = view(Int32Array, info, infoBytes / 4)[infoNumbers + 2];
  const d = take(24), force = take(24), field = take(24 * nOutput);
  return {
    nOutput,
    force(number_, displacement) {
      view(Float64Array, d, 3).set(displacement);
      const status = check(f.phn_force(model, data, number_, d, force, 0, 0), 'phn_force');
      return { status, force: view(Float64Array, force, 3) };
    },
    deform(number_, displacement) {
      view(Float64Array, d, 3).set(displacement);
      check(f.phn_deform(model, data, number_, d, field), 'phn_deform');
      return view(Float64Array, field, 3 * nOutput);
    },
  };
}

// Opens an image of floats.
export function loadImage(wasm, bytes) {
  const { f, take, view, put } = wasm;
  const at = put(bytes), handle = take(4);
  check(f.phn_imagef_open(at, bytes.byteLength, handle), 'phn_imagef_open');
  const image = view(Uint32Array, handle, 1)[0], nOutput = f.phn_imagef_n_output(image);
  const d = take(12), force = take(12), scratch = take(f.phn_imagef_scratch_size(image)), field = take(12 * nOutput);
  return {
    nOutput,
    force(node, displacement) {
      view(Float32Array, d, 3).set(displacement);
      const status = check(f.phn_imagef_force(image, node, d, force), 'phn_imagef_force');
      return { status, force: view(Float32Array, force, 3) };
    },
    deform(node, displacement) {
      view(Float32Array, d, 3).set(displacement);
      check(f.phn_imagef_deform(image, scratch, node, d, field), 'phn_imagef_deform');
      return view(Float32Array, field, 3 * nOutput);
    },
  };
}
