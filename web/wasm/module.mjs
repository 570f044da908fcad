// A minimal interface to a module. It allocates memory after that of the module and never frees it.
import { readFileSync } from 'node:fs';

export function load(file) {
  const { exports } = new WebAssembly.Instance(new WebAssembly.Module(readFileSync(file)), {});
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
  return { f: exports, take, view, put };
}

export function check(status, what) {
  if (status < 0) throw new Error(`${what}: status ${status}`);
  return status;
}
