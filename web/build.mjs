// Builds the npm package `phynness` of web/runtime, and the pages.
// Usage: node build.mjs --wasm phynness.wasm --out FOLDER
// Writes FOLDER/phynness, ready for npm pack, FOLDER/view.html and FOLDER/report.html.
import { execFileSync } from 'node:child_process';
import { copyFileSync, mkdirSync, rmSync } from 'node:fs';
import { createRequire } from 'node:module';
import { dirname, join, resolve } from 'node:path';
import { fileURLToPath } from 'node:url';
import { parseArgs } from 'node:util';
import { build } from 'esbuild';
import { buildPage } from './build_page.mjs';

const here = dirname(fileURLToPath(import.meta.url));
const { values } = parseArgs({ options: { wasm: { type: 'string' }, out: { type: 'string' } } });
if (!values.wasm || !values.out) {
  console.error('usage: node build.mjs --wasm phynness.wasm --out FOLDER');
  process.exit(2);
}
const out = join(resolve(values.out), 'phynness');
rmSync(out, { recursive: true, force: true });
mkdirSync(out, { recursive: true });
await build({
  entryPoints: ['browser.ts', 'node.ts'].map((file) => join(here, 'runtime/src', file)),
  outdir: out,
  bundle: true,
  format: 'esm',
  target: 'es2022',
  external: ['node:*'],
  logLevel: 'warning',
});
const typescript = createRequire(import.meta.url).resolve('typescript/bin/tsc');
execFileSync(process.execPath, [typescript, '-p', join(here, 'runtime/tsconfig.json'), '--outDir', join(out, 'types')],
  { stdio: 'inherit' });
copyFileSync(resolve(values.wasm), join(out, 'phynness.wasm'));
for (const file of ['package.json', 'README.md']) copyFileSync(join(here, 'runtime', file), join(out, file));
copyFileSync(join(here, '../LICENSE'), join(out, 'LICENSE'));
console.log(`${out}: the npm package phynness`);
for (const folder of ['view', 'report']) {
  const page = join(resolve(values.out), `${folder}.html`);
  console.log(`${page}: ${await buildPage(folder, page, values.wasm)} bytes`);
}
