// Builds the npm package `phynness` of web/runtime, and the page of web/view, also as a C++ source for web/pages.
// Usage: node build.mjs phynness.wasm FOLDER EMBEDDED.cpp
// Writes FOLDER/phynness, ready for npm pack, and FOLDER/view.html.
import { execFileSync } from 'node:child_process';
import { copyFileSync, mkdirSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';
import { gzipSync } from 'node:zlib';
import { build } from 'esbuild';

const here = dirname(fileURLToPath(import.meta.url)), resolved = createRequire(import.meta.url).resolve;
const [wasm, folder, embedded] = process.argv.slice(2), out = join(folder, 'phynness');
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
execFileSync(process.execPath, [resolved('typescript/bin/tsc'), '-p', join(here, 'runtime/tsconfig.json'), '--outDir', join(out, 'types')],
  { stdio: 'inherit' });
copyFileSync(wasm, join(out, 'phynness.wasm'));
for (const file of ['package.json', 'README.md']) copyFileSync(join(here, 'runtime', file), join(out, file));
copyFileSync(join(here, '../LICENSE'), join(out, 'LICENSE'));

/** One HTML file with its style and, compressed, its script inside. */
async function page() {
  const module = { name: 'phynness.wasm', setup: (of) => of.onResolve({ filter: /^phynness\.wasm$/ }, () => ({ path: wasm })) };
  const { outputFiles } = await build({
    entryPoints: [join(here, 'view/src/main.ts')], bundle: true, write: false, minify: true, format: 'esm', target: 'es2022',
    charset: 'utf8', legalComments: 'none', loader: { '.wasm': 'binary' }, plugins: [module], logLevel: 'warning',
  });
  const script = gzipSync(outputFiles[0].contents, { level: 9 }).toString('base64');
  const style = readFileSync(join(here, 'view/style.css'), 'utf8');
  return readFileSync(join(here, 'view/page.html'), 'utf8')
    .replace('/*style*/', () => style)
    .replace('/*script*/', () => script);
}

const text = await page(), end = 'phynness';
if (text.includes(`)${end}"`)) throw new Error('the page contains a text that would end a literal of C++');
writeFileSync(join(folder, 'view.html'), text);
// Compilers may limit a string literal to 65,536 bytes, and a character may have 4.
const chunks = text.match(/[^]{1,15000}/gu).map((part) => `R"${end}(${part})${end}",\n`);
writeFileSync(embedded, `#include "embedded.hpp"\n\nconst char* const phynness::embedded_page_chunks[] = {\n${chunks.join('')}nullptr};\n`);
