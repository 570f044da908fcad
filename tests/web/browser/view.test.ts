// Claims, in a real browser: the page of `phynness view` shows the parts of the surface with their legend; a drag gives the force
// that `phynness eval` prints, at the pointer; two tools and two spheres are answered; the wheel stays outside of the body; a
// window of another size, down to a phone, shows the whole body, the title and all buttons; what the page cannot start with is a
// sentence; nothing is logged, requested or executed from the texts in the model.
import { execFileSync } from 'node:child_process';
import { copyFileSync, mkdirSync, readFileSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { gunzipSync, gzipSync } from 'node:zlib';
import axe from 'axe-core';
import type { Browser, Page } from 'puppeteer-core';
import { afterAll, beforeAll, describe, expect, it } from 'vitest';
import { loader } from '../../runtime/src/index.js';
import { dot, scale } from '../../shared/src/vectors.js';
import { placeAt } from '../../view/src/places.js';
import { inwardAt } from '../inward.js';
import { browserName, built, drawn, folder, open, phynness, pixels, start, type Opened } from './browser.js';

type V3 = [number, number, number];

const hostile = `</script><script>alert(1)</script><img src=x onerror=alert(2)> "quotes' \u202Egnp`;
const organ = join(folder, 'organ.html'), block = join(folder, 'block.html');
let browser: Browser, opened: Opened, page: Page;
/** A node that can be held, whose place in the picture belongs to it. */
let front: number;

beforeAll(async () => {
  const model = join(folder, 'hostile');
  mkdirSync(model);
  writeFileSync(join(model, 'model.txt'), titled(readFileSync(join(built.model, 'model.txt'), 'utf8'), hostile));
  copyFileSync(join(built.model, 'mesh.txt'), join(model, 'mesh.txt'));
  phynness('view', model, '-o', organ);
  execFileSync(built.writeModels, [folder]);
  phynness('view', join(folder, 'block'), '--body', join(folder, 'block', 'body.txt'), '-o', block);
  browser = await start();
  await view(organ);
});
afterAll(async () => {
  await closed();
  await browser.close();
});

async function view(file: string): Promise<void> {
  opened = await open(browser, file);
  page = opened.page;
  front = await nodeInFront();
}
async function closed(): Promise<void> {
  await page.close();
  expect(opened.logged).toEqual([]);
  expect(opened.requested).toEqual([]);
}
const ask = <T>(expression: string): Promise<T> => page.evaluate(expression) as Promise<T>;
const textAt = async (selector: string): Promise<string> => {
  await drawn(page); // texts change with the picture
  return ask(`document.querySelector('${selector}').textContent`);
};
/** In the window: of `phynness.seen()` or `phynness.project(node)`. */
const pixelOf = (expression: string): Promise<{ x: number; y: number }> => ask(
  `(() => { const p = phynness.${expression}, box = document.getElementById('canvas').getBoundingClientRect(); return { x: p.x + box.left, y: p.y + box.top }; })()`);
const tools = (): Promise<{ place: { nodes: number[] }; at: V3 }[]> => ask('phynness.session.tools');
const forces = (): Promise<V3[]> => ask('phynness.session.answer.forces');
const size = (f: readonly number[]): number => Math.hypot(...f);

/** What eval answers to tools at nodes. */
function evaluated(held: { node: number; displacement: readonly number[] }[]): V3[] {
  const json = join(folder, 'answer.json');
  phynness('eval', built.model, ...held.flatMap(({ node }) => ['--node', String(node)]),
    ...held.flatMap(({ displacement }) => ['--displacement', displacement.join(',')]), '--json', json);
  return (JSON.parse(readFileSync(json, 'utf8')) as { tools: { force: V3 }[] }).tools.map(({ force }) => force);
}
async function nodeInFront(): Promise<number> {
  const nodes = await ask<number[]>(`(() => { const { clientWidth, clientHeight } = document.getElementById('canvas');
    const away = (n) => Math.hypot(phynness.project(n).x - clientWidth / 2, phynness.project(n).y - clientHeight / 2);
    return [...phynness.session.runtime.active].sort((a, b) => away(a) - away(b)).slice(0, 20); })()`);
  await ask('phynness.set({ probedOnly: true })');
  for (const node of nodes) {
    await drag(await pixelOf(`project(${node})`), 0, 0);
    const [held] = await tools();
    await ask('phynness.hold([])');
    if (held?.place.nodes[0] === node) return node;
  }
  throw new Error('no node can be held by a click on it');
}
async function drag(from: { x: number; y: number }, dx: number, dy: number, wheel = 0): Promise<void> {
  await page.mouse.move(from.x, from.y);
  await page.mouse.down();
  for (let i = 1; i <= 4; ++i) {
    await page.mouse.move(from.x + (dx * i) / 4, from.y + (dy * i) / 4);
    await drawn(page); // browsers join movements between two pictures
  }
  if (wheel !== 0) await page.mouse.wheel({ deltaY: wheel });
  await drawn(page);
  await page.mouse.up();
}
/** Whether all nodes are inside of the picture. */
const allSeen = (): Promise<boolean> => ask(`(() => { const { clientWidth, clientHeight } = document.getElementById('canvas');
  return [...phynness.session.runtime.rows.keys()].map((n) => phynness.project(n)).every(({ x, y }) => x > 0 && x < clientWidth && y > 0 && y < clientHeight); })()`);
/** Those of the elements that cannot be seen and clicked in the window. */
const hidden = (selectors: string[]): Promise<string[]> => ask(`${JSON.stringify(selectors)}.filter((s) => {
  const element = document.querySelector(s), { left, top, width, height } = element.getBoundingClientRect();
  return !element.contains(document.elementFromPoint(left + width / 2, top + height / 2)); })`);
async function violations(): Promise<unknown[]> {
  await page.evaluate(axe.source);
  const found = (await ask('axe.run()')) as { violations: { impact: string; id: string; nodes: { html: string }[] }[] };
  return found.violations.filter(({ impact }) => impact === 'serious' || impact === 'critical').map(({ id, nodes }) => [id, nodes[0]!.html]);
}

describe(`the page in ${browserName}`, () => {
  it('shows hostile texts as texts', async () => {
    expect(await textAt('#title')).toBe(hostile.replace('\u202E', '\\u{202e}'));
    expect(await ask<number[]>("[document.querySelectorAll('img').length, document.querySelectorAll('script').length]")).toEqual([0, 4]);
  });

  it('shows the parts of the surface in the colours of their legend', async () => {
    await ask('phynness.set({ probedOnly: false })');
    expect(await textAt('.parts')).toMatch(/^Nonlinear: trained \(\d+ %\).*Fixed$/);
    const picture = await pixels(page), { x, y } = await pixelOf(`project(${front})`);
    const [swatch] = await ask<number[][]>("[...document.querySelectorAll('.parts i')].map((i) => getComputedStyle(i).backgroundColor.match(/\\d+/g).map(Number))");
    const [red, green, blue] = picture.at(x, y), hue = (r: number, g: number, b: number) => [g / r, b / r];
    hue(red, green, blue).forEach((h, k) => expect(Math.abs(h - hue(...(swatch as V3))[k]!)).toBeLessThan(0.15)); // light changes brightness, and adds some white
    const [pale] = [picture.at(3, 400)];
    expect(Math.abs(pale[0] - pale[2])).toBeLessThan(20); // beside the body
  });

  it('answers drags with the force of eval, in at most three digits, at the place of the pointer', async () => {
    for (const [dx, dy] of [[40, 25], [0, -45]] as const) {
      await ask('phynness.hold([]), phynness.set({ probedOnly: true })');
      const from = await pixelOf(`project(${front})`);
      await drag(from, dx, dy);
      const [tool] = await tools(), to = await pixelOf('seen()');
      expect(tool!.place.nodes).toEqual([front]);
      // Half a pixel on each side: the pointer has whole pixels, and so may have the element.
      expect(Math.hypot(to.x - from.x - dx, to.y - from.y - dy)).toBeLessThan(1.5);
      const force = size(evaluated([{ node: front, displacement: tool!.at }])[0]!), shown = await textAt('#newtons');
      expect(shown.replace(/^0\.0*|\./g, '').length).toBeLessThanOrEqual(3);
      expect(Number(force.toPrecision(shown.replace(/^0\.0*|\./g, '').length))).toBe(Number(shown));
      expect(Math.abs(size((await forces())[0]!) / force - 1)).toBeLessThan(1e-9);
      expect(await textAt('#quantities')).toMatch(/Error of the force \(95 %\)\s*below [0-9.]+ m?N/);
      // The drawn surface, which is smoothed, follows the tool.
      const missing = await ask<number>(`(() => { const { view, session } = phynness, at = view.seen(session.tools[0]), i = 3 * session.runtime.rows.get(${front});
        return Math.hypot(...at.map((x, k) => x - view.positions[i + k])); })()`);
      expect(missing).toBeLessThan(0.02 * size(tool!.at));
    }
  });

  it('holds two tools', async () => {
    const other = await ask<number>(`[...phynness.session.runtime.active].find((n) => {
      const a = phynness.session.runtime.point(n), b = phynness.session.runtime.point(${front}); return Math.hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]) > 0.05; })`);
    const held = [{ node: front, displacement: [0.004, 0, 0.003] }, { node: other, displacement: [0.002, 0, -0.006] }];
    await ask(`phynness.hold(${JSON.stringify(held)})`);
    (await forces()).forEach((force, i) => expect(Math.abs(size(force) / size(evaluated(held)[i]!) - 1)).toBeLessThan(1e-9));
    expect(await textAt('#quantities')).toMatch(/Force of tool 1[\d.]+ NForce of tool 2[\d.]+ N/);
  });

  it('shows a map in the colours of its legend', async () => {
    await ask("phynness.hold([]), phynness.set({ map: 'displacement' })");
    const { x, y } = await pixelOf(`project(${front})`), rest = (await pixels(page)).at(x, y);
    expect(rest[2]).toBeGreaterThan(1.5 * rest[0]); // the map begins with dark blue
    const towards = await ask<V3>('(() => { const { azimuth } = phynness.view.camera; return [0.01 * Math.cos(azimuth), 0.01 * Math.sin(azimuth), 0]; })()');
    await ask(`phynness.hold([{ node: ${front}, displacement: ${JSON.stringify(towards)} }])`);
    const held = await pixelOf('seen()'), now = (await pixels(page)).at(held.x + 16, held.y); // beside the mark of the tool
    expect(now[1]).toBeGreaterThan(now[2]); // and goes through green to yellow
    expect(await textAt('.legend:not(.parts)')).toMatch(/Displacement.*mm/);
    expect(await violations()).toEqual([]);
    await ask("phynness.hold([]), phynness.set({ map: 'parts' })");
  });

  it('shows maps of stiffness: the force of eval over the depth of an inward push, and a legend with the least and the largest value', async () => {
    const { points, triangles, row } = await ask<{ points: number[]; triangles: number[]; row: number }>(`(() => { const { model: { info }, rows } = phynness.session.runtime;
      return { points: [...info.outputPoints, ...info.fixedPoints], triangles: [...info.triangles], row: rows.get(${front}) }; })()`);
    const inward = inwardAt(points, triangles, row);
    for (const depth of [1e-3, 5e-3]) {
      await page.select('#map', `stiffness:${1e3 * depth}`);
      expect(await textAt('.legend:not(.parts) figcaption')).toBe(`Stiffness at ${1e3 * depth} mm [N/m]`);
      const [force] = evaluated([{ node: front, displacement: scale(depth, inward) }]);
      const map = await ask<{ value: number; low: number; high: number }>(`(() => { const { maps, map } = phynness.session,
        { values, scale } = maps.find(({ name }) => name === map).values([]); return { ...scale, value: values[${row}] }; })()`);
      expect(Math.abs((map.value * depth) / dot(force!, inward) - 1)).toBeLessThan(1e-9);
      const shown = (await textAt('.legend-note')).match(/: ([\d.]+) to ([\d.]+) N\/m/)!.slice(1).map(Number);
      expect(shown).toEqual([map.low, map.high].map((x) => Number(x.toPrecision(3))));
    }
    await page.select('#map', 'parts');
  });

  it('stays outside of the body with the wheel, and shows the whole body in a window of another size', async () => {
    await page.mouse.move(400, 400);
    for (let i = 0; i < 6; ++i) await page.mouse.wheel({ deltaY: -1000 });
    await drawn(page);
    const distance = await ask<number>(`(() => { const { view: { camera: { target, distance, azimuth: a, elevation: e }, positions: p }, session } = phynness;
      const eye = [Math.cos(e) * Math.cos(a), Math.cos(e) * Math.sin(a), Math.sin(e)].map((c, k) => target[k] + distance * c); let least = Infinity;
      for (let i = 0; i < p.length; i += 3) least = Math.min(least, Math.hypot(p[i] - eye[0], p[i + 1] - eye[1], p[i + 2] - eye[2]));
      return least / session.bounds.radius; })()`);
    expect(distance).toBeGreaterThan(0.599);
    expect(await allSeen()).toBe(false);
    await page.click('#whole');
    await drawn(page);
    expect(await allSeen()).toBe(true);
    for (const [width, height] of [[800, 700], [390, 844]] as const) {
      await page.setViewport({ width, height });
      await page.waitForFunction(`document.documentElement.scrollWidth === ${width} && phynness.view.size.width <= ${width}`);
      await drawn(page);
      expect(await allSeen()).toBe(true);
      expect(await hidden(['#title', '#whole', '#mode-sphere', '#push', '#let-go'])).toEqual([]);
      expect(await violations()).toEqual([]);
    }
  });

  it('answers two tools that are dragged, and two spheres, with the reduced body', async () => {
    await closed();
    await view(block);
    const rest = () => page.waitForFunction('!phynness.session.restless');
    await page.click('#most-2');
    await drag(await pixelOf('project(32)'), -30, 20);
    await drag(await pixelOf('project(42)'), 25, -30);
    await rest();
    const held = await tools();
    expect(held.length).toBe(2);
    held.forEach(({ at }) => expect(size(at)).toBeGreaterThan(0.002));
    expect(await textAt('#verdict')).not.toBe('unsettled');
    await page.click('#mode-sphere');
    await drawn(page);
    // Each one lowers the surface under the other one, too.
    for (const [node, wheel] of [[32, -520], [42, -560]] as const) await drag(await pixelOf(`project(${node})`), 0, 0, wheel);
    await page.click('#push');
    await rest();
    (await forces()).forEach((force) => expect(size(force)).toBeGreaterThan(0.001));
  });

  it('is committed for a liver, with the forces of the present runtime', async () => {
    await closed();
    const committed = join(built.source, 'docs/liver.html');
    const load = loader(() => WebAssembly.compile(new Uint8Array(readFileSync(join(built.package, 'phynness.wasm')))));
    const model = await load((JSON.parse(elementOf(readFileSync(committed, 'utf8'), 'data')) as { model: string }).model);
    await view(committed);
    for (const place of [placeAt(front), model.nearest(await ask<V3>(`phynness.session.runtime.point(${front}).map((x) => x + 0.004)`)).tool]) {
      const tool = JSON.stringify({ place, at: [0.004, -0.002, 0.003] });
      await ask(`phynness.session.tools = [${tool}], phynness.session.update()`);
      expect(Math.abs(size((await forces())[0]!) / size([...model.force(place, [0.004, -0.002, 0.003]).force]) - 1)).toBeLessThan(1e-9);
      expect(await ask<number[]>('phynness.session.answer.bounds')).toEqual([model.bound(place, [0.004, -0.002, 0.003])]);
    }
  });

  it.each([
    ['a model of another version', (html: string) => withElement(html, 'data', (data) => data.replace(/"phynness-model \d+/, '"phynness-model 999')), /another version.*phynness view/],
    ['a damaged runtime', (html: string) => withElement(html, 'script', (script) => script.replaceAll('AGFzbQEAAAA', 'AGFzbQIAAAA')), /cannot start: .*phynness view/],
    ['a damaged script', (html: string) => html.replace('>H4sI', '>H4sX'), /cannot start: .*decompressed.*phynness view/],
  ])('says in a sentence that it cannot start with %s', async (name, damaged, sentence) => {
    const file = join(folder, `${name.replaceAll(' ', '_')}.html`), html = readFileSync(block, 'utf8');
    expect(damaged(html)).not.toBe(html);
    writeFileSync(file, damaged(html));
    const { page: other } = await open(browser, file, { ready: "!document.getElementById('problem').hidden" });
    expect(await other.evaluate("document.getElementById('problem').textContent")).toMatch(sentence);
    await other.close();
  });
});

/** The text in the element phynness-`name` of a page, which is base64 of gzip. */
const elementOf = (page: string, name: 'data' | 'script'): string =>
  gunzipSync(Buffer.from(page.match(`id="phynness-${name}">([^<]*)`)![1]!, 'base64')).toString();
/** A page with a changed text in such an element. */
const withElement = (page: string, name: 'data' | 'script', changed: (text: string) => string): string =>
  page.replace(new RegExp(`(?<=id="phynness-${name}">)[^<]*`), gzipSync(changed(elementOf(page, name))).toString('base64'));

/** A model's text with another title, and the checksum of what it holds: 64-bit FNV-1a (formats/model.md). */
function titled(model: string, title: string): string {
  const text = model.slice(0, model.lastIndexOf('checksum ')).replace(/^title .*$/m, () => `title ${title}`);
  let hash = 0xcbf29ce484222325n;
  for (const byte of Buffer.from(text)) hash = ((hash ^ BigInt(byte)) * 0x100000001b3n) & 0xffffffffffffffffn;
  return `${text}checksum ${hash.toString(16).padStart(16, '0')}\n`;
}
