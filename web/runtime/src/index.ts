// What both entry points have in common; browser.ts and node.ts add where phynness.wasm comes from.
import { Model } from './model.js';

export { Contact, type Sphere, type Touch } from './contact.js';
export { Model, type Info, type Level, type Response, type Trust } from './model.js';
export { PhynnessError, warningsOf, type Warning } from './status.js';
export { Surface } from './surface.js';
export { toolAt, type Tool, type Vector } from './tool.js';
export { Tools, type Coupled } from './tools.js';

export type ModelText = string | Uint8Array | ArrayBuffer;

/** A function that loads models with a module, which is compiled once. */
export function loader(module: () => Promise<WebAssembly.Module>): (text: ModelText) => Promise<Model> {
  let compiled: Promise<WebAssembly.Module> | undefined;
  return async (text) => {
    compiled ??= module();
    const bytes = typeof text === 'string' ? new TextEncoder().encode(text) : new Uint8Array(text);
    return new Model(await compiled, bytes);
  };
}
