// Builds the npm package `phynness` of web/runtime, and the pages.
// Usage: node build.mjs --wasm phynness.wasm --out FOLDER
// Writes FOLDER/phynness, ready for npm pack, FOLDER/view.html and FOLDER/report.html.
import { execFileSync } from 'node:child_process';
import { copyFileSync, mkdirSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { dirname, join, resolve } from 'node:path';
import { fileURLToPath } from 'node:url';
import { parseArgs } from 'node:util';
import { build } from 'esbuild';

const here = dirname(fileURLToPath(import.meta.url)), resolved = createRequire(import.meta.url).resolve;
/** One HTML file with its style and script inside, from page.html, style.css and src/main.ts of a folder.
 * @param folder  "view" or "report"; out: path of the page; wasm: path of phynness.wasm. Returns the size in bytes. */
async function buildPage(folder, out, wasm) {
  const module = { name: 'phynness.wasm', setup: (of) => of.onResolve({ filter: /^phynness\.wasm$/ }, () => ({ path: resolve(wasm) })) };
  const { outputFiles } = await build({
    entryPoints: [join(here, folder, 'src/main.ts')], bundle: true, write: false, minify: true, format: 'esm', target: 'es2022',
    charset: 'utf8', legalComments: 'none', loader: { '.wasm': 'binary' }, plugins: [module], logLevel: 'warning',
  });
  const script = outputFiles[0].text;
  if (/<\/script|<!--/i.test(script)) throw new Error('the script contains a text that would end its element');
  const style = [resolved('uplot/dist/uPlot.min.css'), join(here, folder, 'style.css')]
    .map((file) => readFileSync(file, 'utf8')).join('\n');
  const page = readFileSync(join(here, folder, 'page.html'), 'utf8')
    .replace('/*style*/', () => style)
    .replace('/*script*/', () => script);
  writeFileSync(out, page);
  return Buffer.byteLength(page);
}

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
execFileSync(process.execPath, [resolved('typescript/bin/tsc'), '-p', join(here, 'runtime/tsconfig.json'), '--outDir', join(out, 'types')],
  { stdio: 'inherit' });
copyFileSync(resolve(values.wasm), join(out, 'phynness.wasm'));
for (const file of ['package.json', 'README.md']) copyFileSync(join(here, 'runtime', file), join(out, file));
copyFileSync(join(here, '../LICENSE'), join(out, 'LICENSE'));
console.log(`${out}: the npm package phynness`);
for (const folder of ['view', 'report']) {
  const page = join(resolve(values.out), `${folder}.html`);
  console.log(`${page}: ${await buildPage(folder, page, values.wasm)} bytes`);
}
