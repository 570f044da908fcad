// Writes web/runtime/src/layout.ts: sizes of the structs of the C interface and offsets of their members, from
// layout.wasm, which the compiler made of layout.c.
// Usage: node layout.mjs layout.wasm > layout.ts
import { readFileSync } from 'node:fs';

export function layoutOf(bytes) {
  const { exports } = new WebAssembly.Instance(new WebAssembly.Module(bytes), {});
  exports.__wasm_call_ctors();
  const words = new Uint32Array(exports.memory.buffer), text = new Uint8Array(exports.memory.buffer);
  const layout = {};
  for (let at = exports.phn_layout() / 4; words[at] !== 0; at += 2) {
    const begin = words[at], name = new TextDecoder().decode(text.subarray(begin, text.indexOf(0, begin)));
    layout[name] = words[at + 1];
  }
  return layout;
}

export function layoutText(layout) {
  const entries = Object.entries(layout).map(([name, bytes]) => `'${name}': ${bytes},`);
  const lines = entries.map((entry, i) => (i % 4 === 0 ? `${i > 0 ? '\n' : ''}  ` : ' ') + entry);
  return `// Written by web/wasm/layout.mjs. Bytes in 32-bit memory: sizes of structs, and offsets of their members.
export const layout = {
${lines.join('')}
} as const;
`;
}

if (process.argv[1]?.endsWith('layout.mjs')) {
  if (process.argv.length !== 3) {
    console.error('usage: node layout.mjs layout.wasm > layout.ts');
    process.exit(2);
  }
  process.stdout.write(layoutText(layoutOf(readFileSync(process.argv[2]))));
}
