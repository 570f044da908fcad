// Builds the npm package `phynness` of web/runtime, and the pages, also as a C++ source for web/pages.
// Usage: node build.mjs phynness.wasm FOLDER EMBEDDED.cpp
// Writes FOLDER/phynness, ready for npm pack, FOLDER/view.html and FOLDER/report.html.
import { execFileSync } from 'node:child_process';
import { copyFileSync, mkdirSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';
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

/** One HTML file with its style and script inside, from page.html, style.css and src/main.ts of "view" or "report". */
async function pageOf(name) {
  const module = { name: 'phynness.wasm', setup: (of) => of.onResolve({ filter: /^phynness\.wasm$/ }, () => ({ path: wasm })) };
  const { outputFiles } = await build({
    entryPoints: [join(here, name, 'src/main.ts')], bundle: true, write: false, minify: true, format: 'esm', target: 'es2022',
    charset: 'utf8', legalComments: 'none', loader: { '.wasm': 'binary' }, plugins: [module], logLevel: 'warning',
  });
  const script = outputFiles[0].text;
  if (/<\/script|<!--/i.test(script)) throw new Error('the script contains a text that would end its element');
  const style = [resolved('uplot/dist/uPlot.min.css'), join(here, name, 'style.css')]
    .map((file) => readFileSync(file, 'utf8')).join('\n');
  return readFileSync(join(here, name, 'page.html'), 'utf8')
    .replace('/*style*/', () => style)
    .replace('/*script*/', () => script);
}

/** A literal of C++. Bytes other than plain ASCII become octal escapes of three digits. */
function literal(bytes) {
  let text = '';
  for (const byte of bytes) {
    const plain = byte >= 32 && byte < 127 && byte !== 34 && byte !== 92 && byte !== 63;
    text += plain ? String.fromCharCode(byte) : `\\${byte.toString(8).padStart(3, '0')}`;
  }
  return `"${text}"`;
}

let source = '#include "embedded.hpp"\n\nnamespace phynness {\n\n', list = '';
const bytesPerChunk = 15000; // compilers may limit a string literal to 65,536 bytes, and every byte may need 4 characters
for (const name of ['view', 'report']) {
  const page = await pageOf(name), bytes = Buffer.from(page);
  writeFileSync(join(folder, `${name}.html`), page);
  source += `static const char* const ${name}_chunks[] = {\n`;
  for (let at = 0; at < bytes.length; at += bytesPerChunk) source += `    ${literal(bytes.subarray(at, at + bytesPerChunk))},\n`;
  source += '    nullptr};\n';
  list += `    {"${name}.html", ${name}_chunks},\n`;
}
writeFileSync(embedded, `${source}\nconst EmbeddedFile embedded_files[] = {\n${list}    {nullptr, nullptr}};\n\n}  // namespace phynness\n`);
