// What both entry points have in common; browser.ts and node.ts add where phynness.wasm comes from.
import { Model } from './model.js';
import { bytesOfText, type ModelText } from './engine.js';

export type { Body, BodyInfo } from './body.js';
export { Contact, type Sphere, type Touch } from './contact.js';
export { Model, type Info, type Level, type Provenance, type Response } from './model.js';
export { PhynnessError, warningsOf, type Warning } from './status.js';
export { Surface } from './surface.js';
export type { ModelText } from './engine.js';
export { toolAt, type Place, type Tool, type Vector } from './tool.js';
export { Tools, type Coupled } from './tools.js';

/** A function that loads models with a module, which is compiled once. */
export function loader(module: () => Promise<WebAssembly.Module>): (text: ModelText) => Promise<Model> {
  let compiled: Promise<WebAssembly.Module> | undefined;
  return async (text) => {
    const bytes = bytesOfText(text);
    compiled ??= module();
    compiled.catch(() => (compiled = undefined));  // the next load tries again
    return Model.create(await compiled, bytes);
  };
}
