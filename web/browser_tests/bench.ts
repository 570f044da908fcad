// Times of the page and of the runtime, in browsers, in Node and native, in one run.
// Usage: tools/bench web [MODEL_DIR ...] [--json FILE]
import { execFileSync } from 'node:child_process';
import { mkdtempSync, readFileSync, statSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { basename, join, resolve } from 'node:path';
import { pathToFileURL } from 'node:url';
import type { Browser, Page } from 'puppeteer-core';
import { Model } from '../runtime/src/model.js';
import { drawn, start, type BrowserName } from './browser.js';

const [phynness, wasm, ...words] = process.argv.slice(2);
const folder = mkdtempSync(join(tmpdir(), 'phynness-bench-')), loads = 5;
const median = (x: number[]): number => [...x].sort((a, b) => a - b)[x.length >> 1]!;

interface Timed {
  info: { activeNodes: ArrayLike<number>; outputNodes: ArrayLike<number> };
  force(node: number, d: number[]): unknown;
  deform(node: number, d: number[], out: Float64Array): unknown;
}

/** Runs in a page and in Node. @returns microseconds of a force and of a deformation, least of ten rounds */
function times(model: Timed): { force: number; deform: number } {
  const node = model.info.activeNodes[0]!, out = new Float64Array(3 * model.info.outputNodes.length), d = [0, 0, -0.004];
  const least = (n: number, act: () => unknown) => {
    let best = Infinity;
    for (let round = 0; round < 10; ++round) {
      const begin = performance.now();
      for (let i = 0; i < n; ++i) {
        d[0] = 1e-3 * (i % 7);
        act();
      }
      best = Math.min(best, (1e3 * (performance.now() - begin)) / n);
    }
    return best;
  };
  return { force: least(20000, () => model.force(node, d)), deform: least(2000, () => model.deform(node, d, out)) };
}

async function loaded(browser: Browser, file: string): Promise<{ page: Page; picture: number; force: number }> {
  const page = await browser.newPage();
  await page.setViewport({ width: 1280, height: 800 });
  const begin = performance.now();
  await page.goto(pathToFileURL(file).href);
  await page.waitForFunction('globalThis.phynness');
  await drawn(page);
  const picture = performance.now() - begin;
  await page.evaluate('phynness.hold([{ node: phynness.model.info.activeNodes[0], displacement: [0, 0, -0.005] }])');
  const force = performance.now() - begin;
  return { page, picture, force };
}

/** Milliseconds from a moved tool to the finished picture, median of 30, at every smoothness. */
async function frames(page: Page): Promise<number[]> {
  return (await page.evaluate(`(() => [0, 1, 2, 3].map((subdivision) => {
    phynness.set({ subdivision });
    const node = phynness.model.info.activeNodes[0], took = [], gl = document.getElementById('canvas').getContext('webgl2');
    for (let i = 0; i < 30; ++i) {
      const begin = performance.now();
      phynness.hold([{ node, displacement: [0, 0, -0.0001 * i] }]);
      gl.finish();
      took.push(performance.now() - begin);
    }
    return took.sort((a, b) => a - b)[15];
  }))()`)) as number[];
}

const jsonAt = words.indexOf('--json'), jsonFile = jsonAt >= 0 ? words.splice(jsonAt, 2)[1] : undefined;
const results: Record<string, number> = {};
for (const model of words.map((word) => resolve(word))) {
  const page = join(folder, 'organ.html'), name = basename(resolve(model, '..')) + '/' + basename(model);
  execFileSync(phynness!, ['view', model, '-o', page]);
  const bytes = statSync(page).size, own = statSync(join(model, 'model.txt')).size;
  console.log(`\n${name}: page ${bytes} bytes, model.txt ${own} bytes`);
  const put = (key: string, value: number) => (results[`${name} ${key}`] = value);
  put('page bytes', bytes);
  const native = join(folder, 'native.json');
  execFileSync(phynness!, ['bench', model, '--json', native], { stdio: ['ignore', 'ignore', 'inherit'] });
  const levels = (JSON.parse(readFileSync(native, 'utf8')) as { levels: { force_us: number; deformation_us: number }[] }).levels.at(-1)!;
  const rows: [string, number, number][] = [['native', levels.force_us, levels.deformation_us]];
  const node = times(await Model.create(new WebAssembly.Module(new Uint8Array(readFileSync(wasm!))), new Uint8Array(readFileSync(join(model, 'model.txt')))) as unknown as Timed);
  rows.push(['Node', node.force, node.deform]);
  for (const kind of ['chromium', 'firefox'] as BrowserName[]) {
    const browser = await start(kind);
    const pictures: number[] = [], forces: number[] = [];
    let page_: Page | null = null;
    for (let i = 0; i < loads; ++i) {
      await page_?.close();
      const one = await loaded(browser, page);
      page_ = one.page;
      pictures.push(one.picture);
      forces.push(one.force);
    }
    const us = (await page_!.evaluate(`(${times.toString()})(phynness.model)`)) as { force: number; deform: number };
    rows.push([kind, us.force, us.deform]);
    const ms = await frames(page_!);
    console.log(`${kind}: first picture ${median(pictures).toFixed(0)} ms, first force ${median(forces).toFixed(0)} ms (medians of ${loads} loads); `
      + `a moved tool and its picture at smoothness 0 to 3: ${ms.map((x) => x.toFixed(1)).join(', ')} ms`);
    put(`${kind} first picture ms`, median(pictures));
    put(`${kind} first force ms`, median(forces));
    ms.forEach((x, i) => put(`${kind} smoothness ${i} ms`, x));
    await browser.close();
  }
  console.log(`${''.padEnd(10)} ${'force us'.padStart(10)} ${'deform us'.padStart(10)} ${'over native'.padStart(12)}`);
  for (const [kind, force, deform] of rows) {
    console.log(`${kind.padEnd(10)} ${force.toFixed(3).padStart(10)} ${deform.toFixed(2).padStart(10)} ${(force / rows[0]![1]).toFixed(2).padStart(12)}`);
    put(`${kind} force us`, force);
    put(`${kind} deform us`, deform);
  }
}
if (jsonFile) writeFileSync(jsonFile, `${JSON.stringify(results, null, 2)}\n`);
