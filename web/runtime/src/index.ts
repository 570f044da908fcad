// What both entry points have in common; browser.ts and node.ts add where phynness.wasm comes from.
import { Model } from './model.js';

export { Contact, type Sphere, type Touch } from './contact.js';
export { Model, type Info, type Level, type Provenance, type Response, type Trust } from './model.js';
export { PhynnessError, warningsOf, type Warning } from './status.js';
export { Surface } from './surface.js';
export { toolAt, type Tool, type Vector } from './tool.js';
export { Tools, type Coupled } from './tools.js';

export type ModelText = string | ArrayBufferView | ArrayBuffer;

function bytesOf(text: ModelText): Uint8Array {
  if (typeof text === 'string') return new TextEncoder().encode(text);
  if (ArrayBuffer.isView(text)) return new Uint8Array(text.buffer, text.byteOffset, text.byteLength);
  return new Uint8Array(text);
}

/** A function that loads models with a module, which is compiled once. */
export function loader(module: () => Promise<WebAssembly.Module>): (text: ModelText) => Promise<Model> {
  let compiled: Promise<WebAssembly.Module> | undefined;
  return async (text) => {
    const bytes = bytesOf(text);
    compiled ??= module();
    compiled.catch(() => (compiled = undefined));  // the next load tries again
    return Model.create(await compiled, bytes);
  };
}
