// Entry point of browsers and bundlers: phynness.wasm lies beside this file.
import { loader } from './index.js';

export * from './index.js';

/** Loads the text of a model.txt. @throws PhynnessError with the reason and the byte if it is refused */
export const modelFromText = loader(async () => {
  const response = await fetch(new URL('./phynness.wasm', import.meta.url));
  if (!response.ok) throw new Error(`phynness.wasm: ${response.status} ${response.statusText}`);
  return WebAssembly.compile(await response.arrayBuffer());
});
