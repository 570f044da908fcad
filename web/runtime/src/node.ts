// Entry point of Node: phynness.wasm lies beside this file.
import { readFile } from 'node:fs/promises';
import { loader } from './index.js';

export * from './index.js';

/** Loads the text of a model.txt. @throws PhynnessError with the reason and the byte if it is refused */
export const modelFromText = loader(async () =>
  WebAssembly.compile(new Uint8Array(await readFile(new URL('./phynness.wasm', import.meta.url)))),
);
