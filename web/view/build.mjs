// Builds the page of `phynness view`: one HTML file with its style, its script and the WebAssembly module inside.
import { readFileSync, writeFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { dirname, join, resolve } from 'node:path';
import { fileURLToPath } from 'node:url';
import { build } from 'esbuild';

const here = dirname(fileURLToPath(import.meta.url));

/** @param wasm  path of phynness.wasm; out: path of the page. Returns the size of the page in bytes. */
export async function buildView(wasm, out) {
  const module = { name: 'phynness.wasm', setup: (of) => of.onResolve({ filter: /^phynness\.wasm$/ }, () => ({ path: resolve(wasm) })) };
  const { outputFiles } = await build({
    entryPoints: [join(here, 'src/main.ts')],
    bundle: true,
    write: false,
    minify: true,
    format: 'esm',
    target: 'es2022',
    charset: 'utf8',
    legalComments: 'none',
    loader: { '.wasm': 'binary' },
    plugins: [module],
    logLevel: 'warning',
  });
  const script = outputFiles[0].text;
  if (/<\/script|<!--/i.test(script)) throw new Error('the script contains a text that would end its element');
  const style = `${readFileSync(createRequire(import.meta.url).resolve('uplot/dist/uPlot.min.css'), 'utf8')}\n${readFileSync(join(here, 'style.css'), 'utf8')}`;
  const page = readFileSync(join(here, 'page.html'), 'utf8')
    .replace('/*style*/', () => style)
    .replace('/*script*/', () => script);
  writeFileSync(out, page);
  return Buffer.byteLength(page);
}

if (process.argv[1] === fileURLToPath(import.meta.url)) {
  const [wasm, out] = process.argv.slice(2);
  console.log(`${out}: ${await buildView(wasm, out)} bytes`);
}
