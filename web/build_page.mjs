// One HTML file with its style and script inside, from page.html, style.css and src/main.ts of a folder.
import { readFileSync, writeFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { dirname, join, resolve } from 'node:path';
import { fileURLToPath } from 'node:url';
import { build } from 'esbuild';

const here = dirname(fileURLToPath(import.meta.url));

/** @param folder  "view" or "report"; out: path of the page; wasm: path of phynness.wasm. Returns the size in bytes. */
export async function buildPage(folder, out, wasm) {
  const module = { name: 'phynness.wasm', setup: (of) => of.onResolve({ filter: /^phynness\.wasm$/ }, () => ({ path: resolve(wasm) })) };
  const { outputFiles } = await build({
    entryPoints: [join(here, folder, 'src/main.ts')], bundle: true, write: false, minify: true, format: 'esm', target: 'es2022',
    charset: 'utf8', legalComments: 'none', loader: { '.wasm': 'binary' }, plugins: [module], logLevel: 'warning',
  });
  const script = outputFiles[0].text;
  if (/<\/script|<!--/i.test(script)) throw new Error('the script contains a text that would end its element');
  const style = [createRequire(import.meta.url).resolve('uplot/dist/uPlot.min.css'), join(here, folder, 'style.css')]
    .map((file) => readFileSync(file, 'utf8')).join('\n');
  const page = readFileSync(join(here, folder, 'page.html'), 'utf8')
    .replace('/*style*/', () => style)
    .replace('/*script*/', () => script);
  writeFileSync(out, page);
  return Buffer.byteLength(page);
}
