// Builds the script and the style of reports: report.js and report.css.
import { readFileSync, writeFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';
import { build } from 'esbuild';

const here = dirname(fileURLToPath(import.meta.url));

/** @param out  folder. Returns the bytes of both. */
export async function buildReport(out) {
  const { outputFiles } = await build({
    entryPoints: [join(here, 'src/main.ts')], bundle: true, write: false, minify: true, format: 'esm', target: 'es2022',
    charset: 'utf8', legalComments: 'none', logLevel: 'warning',
  });
  const script = outputFiles[0].text;
  if (/<\/script|<!--/i.test(script)) throw new Error('the script contains a text that would end its element');
  const style = `${readFileSync(createRequire(import.meta.url).resolve('uplot/dist/uPlot.min.css'), 'utf8')}\n${readFileSync(join(here, 'style.css'), 'utf8')}`;
  writeFileSync(join(out, 'report.js'), script);
  writeFileSync(join(out, 'report.css'), style);
  return Buffer.byteLength(script) + Buffer.byteLength(style);
}
