// Claims, in a real browser: the page of `phynness view` shows the body; a drag gives the force that `phynness eval`
// prints and moves the vertex to the pointer; so do two tools, levels and the keyboard alone;
// the saved surface is valid glTF; nothing is logged, requested or executed from the texts in the model.
import { execFileSync } from 'node:child_process';
import { copyFileSync, mkdirSync, readFileSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import axe from 'axe-core';
import { validateBytes } from 'gltf-validator';
import type { Browser, Page } from 'puppeteer-core';
import { afterAll, afterEach, beforeAll, describe, expect, it } from 'vitest';
import { browserName, built, drawn, folder, offered, open, phynness, pixels, start, type Opened } from './browser.js';

type V3 = [number, number, number];
interface Pixel { x: number; y: number }

const organ = join(folder, 'organ.html');
let browser: Browser, opened: Opened | null = null;

beforeAll(async () => {
  phynness('view', built.model, '-o', organ);
  browser = await start();
  front = await nodeInFront(await view());
  await opened!.page.close();
  opened = null;
  expect(front).toBeGreaterThanOrEqual(0);
});
afterAll(async () => browser?.close());
afterEach(async () => {
  const now = opened;
  opened = null;
  if (!now) return;
  const { logged, requested } = now;
  await now.page.close();
  expect(logged).toEqual([]);
  expect(requested).toEqual([]);
});

async function view(options: Parameters<typeof open>[2] = {}, file = organ): Promise<Page> {
  opened = await open(browser, file, options);
  return opened.page;
}
const ask = <T>(page: Page, expression: string): Promise<T> => page.evaluate(expression) as Promise<T>;
const pixelOf = (page: Page, node: number): Promise<Pixel> => ask(page,
  `(() => { const p = phynness.project(${node}), box = document.getElementById('canvas').getBoundingClientRect(); return { x: p.x + box.left, y: p.y + box.top }; })()`);
const textAt = async (page: Page, selector: string): Promise<string> => {
  await drawn(page); // texts change with the picture
  return ask(page, `document.querySelector('${selector}').textContent`);
};
const tools = (page: Page): Promise<{ place: { nodes: number[] }; displacement: V3 }[]> => ask(page, 'phynness.state.tools');

interface Answer { tools: { force: V3 }[] }
/** What eval answers to tools at nodes. */
function evaluated(held: { node: number; displacement: readonly number[] }[], ...more: string[]): V3[] {
  const json = join(folder, 'answer.json');
  phynness('eval', built.model, ...held.flatMap(({ node }) => ['--node', String(node)]),
    ...held.flatMap(({ displacement }) => ['--displacement', displacement.join(',')]), ...more, '--json', json);
  return (JSON.parse(readFileSync(json, 'utf8')) as Answer).tools.map(({ force }) => force);
}
const six = (x: number): string => x.toPrecision(6);
const size = (f: readonly number[]): number => Math.hypot(...f);

/** A node that can be held and whose place in the picture belongs to it; -1: none. */
let front = -1;
async function nodeInFront(page: Page): Promise<number> {
  const nodes = await ask<number[]>(page, `(() => { const canvas = document.getElementById('canvas'), x = canvas.clientWidth / 2, y = canvas.clientHeight / 2;
    const away = (n) => Math.hypot(phynness.project(n).x - x, phynness.project(n).y - y); return [...phynness.model.info.activeNodes].sort((a, b) => away(a) - away(b)).slice(0, 20); })()`);
  for (const node of nodes) {
    await drag(page, node, 0, 0);
    const held = await tools(page);
    await ask(page, 'phynness.hold([])');
    if (held[0]?.place.nodes[0] === node) return node;
  }
  return -1;
}

async function drag(page: Page, node: number, dx: number, dy: number): Promise<Pixel> {
  const from = await pixelOf(page, node);
  await page.mouse.move(from.x, from.y);
  await page.mouse.down();
  for (let i = 1; i <= 4; ++i) {
    await page.mouse.move(from.x + (dx * i) / 4, from.y + (dy * i) / 4);
    await drawn(page); // browsers join movements between two pictures
  }
  await page.mouse.up();
  return from;
}

describe(`the page in ${browserName}`, () => {
  it('shows the body in the colours of its parts', async () => {
    const page = await view();
    await ask(page, 'phynness.set({ nodes: false })');
    const picture = await pixels(page), box = await ask<DOMRect>(page, "document.getElementById('canvas').getBoundingClientRect().toJSON()");
    const luminance: number[] = [];
    for (let y = box.y + 2; y < box.y + box.height - 2; y += 7)
      for (let x = box.x + 2; x < box.x + box.width - 2; x += 7) luminance.push(picture.at(x, y).reduce((a, b) => a + b, 0) / 3);
    const mean = luminance.reduce((a, b) => a + b, 0) / luminance.length;
    const deviation = Math.sqrt(luminance.reduce((a, b) => a + (b - mean) ** 2, 0) / luminance.length);
    expect(deviation).toBeGreaterThan(15); // an empty picture has below 3; the body covers a third and is darker by 80
    const { x, y } = await pixelOf(page, front), [red, green, blue] = picture.at(x, y);
    expect(red).toBeGreaterThan(green + 20);
    expect(red).toBeGreaterThan(blue + 20);
  });

  it('shows a map in the colours of its legend', async () => {
    const page = await view();
    await ask(page, "phynness.set({ nodes: false, map: 'displacement' })");
    const { x, y } = await pixelOf(page, front), rest = (await pixels(page)).at(x, y);
    expect(rest[2]).toBeGreaterThan(1.5 * rest[0]); // the map begins with dark blue
    const away = await ask<V3>(page, `(() => { const { azimuth } = phynness.camera(); return [0.01 * Math.cos(azimuth), 0.01 * Math.sin(azimuth), 0]; })()`);
    await ask(page, `phynness.hold([{ node: ${front}, displacement: ${JSON.stringify(away)} }])`);
    const held = await pixelOf(page, front), now = (await pixels(page)).at(held.x + 16, held.y); // beside the mark of the tool
    expect(now[1]).toBeGreaterThan(now[2]); // and goes through green to yellow
    expect(await textAt(page, '.legend')).toMatch(/Displacement.*mm/);
  });

  it('answers a drag with the force of eval, at the place of the pointer', async () => {
    const page = await view();
    await ask(page, 'phynness.set({ subdivision: 0 })');
    for (const [dx, dy] of [[40, 25], [-30, 60], [0, -45]] as const) {
      await ask(page, 'phynness.hold([])');
      const from = await drag(page, front, dx, dy);
      const [tool] = await tools(page), to = await pixelOf(page, front);
      expect(tool!.place.nodes).toEqual([front]);
      // Half a pixel on each side: the pointer has whole pixels, and so may have the element.
      expect(Math.abs(to.x - from.x - dx)).toBeLessThan(1);
      expect(Math.abs(to.y - from.y - dy)).toBeLessThan(1);
      const [force] = evaluated([{ node: front, displacement: tool!.displacement }]);
      expect(await textAt(page, '#newtons')).toBe(six(size(force!)));
      expect(await textAt(page, '#quantities')).toMatch(/Error of the force \(95 %\)\s*below [0-9.]+ m?N/);
      // The vertex itself, in single precision.
      const point = await ask<V3>(page, `phynness.point(${front})`);
      const nearest = await ask<number>(page, `(() => { const p = phynness.positions(), to = ${JSON.stringify(point.map((x, k) => x + tool!.displacement[k]!))}; let best = 1;
        for (let i = 0; i < p.length; i += 3) best = Math.min(best, Math.hypot(p[i]-to[0], p[i+1]-to[1], p[i+2]-to[2])); return best; })()`);
      expect(nearest).toBeLessThan(1e-7);
    }
  });

  it('holds two tools, and between nodes', async () => {
    const page = await view(), other = await ask<number>(page, `[...phynness.model.info.activeNodes].find((n) => {
      const a = phynness.point(n), b = phynness.point(${front}); return Math.hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]) > 0.05; })`);
    await page.click('#most-2');
    await drag(page, front, 20, 20);
    await ask(page, `phynness.hold([...phynness.state.tools.map((t) => ({ node: t.place.nodes[0], displacement: t.displacement })), { node: ${other}, displacement: [0.002, 0, -0.006] }])`);
    const held = (await tools(page)).map(({ place, displacement }) => ({ node: place.nodes[0]!, displacement }));
    expect(held.map(({ node }) => node)).toEqual([front, other]);
    const cells = await ask<string[]>(page, "[...document.querySelectorAll('#forces tbody td:last-child')].map((cell) => cell.textContent)");
    expect(cells).toEqual(evaluated(held).map((force) => six(size(force))));
  });

  it('answers two tools that are dragged with the reduced body', async () => {
    execFileSync(built.writeModels, [folder]);
    const file = join(folder, 'block.html'), block = join(folder, 'block');
    phynness('view', block, '--body', join(block, 'body.txt'), '-o', file);
    const page = await view({}, file), rest = () => page.waitForFunction('!phynness.restless', { timeout: 5000 });
    expect(await textAt(page, '#body-note')).toMatch(/reduced body \(120 modes, 96 cells\)/);
    await page.click('#most-2');
    await drag(page, 32, -30, 20);
    await drag(page, 42, 25, -30);
    await rest();
    const held = await tools(page);
    expect(held.length).toBe(2);
    held.forEach(({ displacement }) => expect(size(displacement)).toBeGreaterThan(0.002));
    expect(await textAt(page, '#verdict')).not.toBe('unsettled');
    expect(await textAt(page, '#quantities')).toMatch(/Error of the force \(95 %\)\s*below [0-9.]+ m?N/);
  });

  it('changes the level', async () => {
    const page = await view(), n = await ask<number>(page, 'phynness.model.levels.length');
    if (n === 0) return;
    const displacement = [0.001, 0.002, -0.009], held = [{ node: front, displacement }];
    await ask(page, `phynness.hold(${JSON.stringify(held)})`);
    await page.select('#level', '0');
    expect(await textAt(page, '#newtons')).toBe(six(size(evaluated(held, '--level', '0')[0]!)));
  });

  it('touches with a sphere', async () => {
    const page = await view();
    await page.click('#mode-sphere');
    await page.waitForFunction("document.getElementById('verdict').textContent === 'no contact'", { timeout: 5000 });
    const { x, y } = await pixelOf(page, front);
    await page.mouse.move(x, y);
    await page.mouse.down();
    await page.mouse.wheel({ deltaY: -600 });
    await page.waitForFunction('phynness.answer.touches[0]?.inContact', { timeout: 5000 });
    expect(Number(await textAt(page, '#newtons'))).toBeGreaterThan(0.001);
    await page.mouse.up();
  });

  it('can be probed by the keyboard alone', async () => {
    const page = await view();
    for (let i = 0; i < 40 && (await ask<string>(page, 'document.activeElement.id')) !== 'canvas'; ++i) await page.keyboard.press('Tab');
    expect(await ask<string>(page, 'document.activeElement.id')).toBe('canvas');
    await page.keyboard.press('n');
    for (let i = 0; i < 4; ++i) await page.keyboard.press('i');
    await page.keyboard.press('ArrowRight');
    const [tool] = await tools(page);
    expect(size(tool!.displacement)).toBeGreaterThan(0.003);
    const [force] = evaluated([{ node: tool!.place.nodes[0]!, displacement: tool!.displacement }]);
    expect(await textAt(page, '#newtons')).toBe(six(size(force!)));
    expect(await textAt(page, '#status')).toMatch(/Node \d+, .* millimetres, .* newtons/i);
    await page.keyboard.press('Escape');
    expect(await tools(page)).toEqual([]);
  });

  it('keeps its state in the address', async () => {
    const page = await view();
    await ask(page, `phynness.hold([{ node: ${front}, displacement: [0.001, 0, -0.012] }])`);
    await ask(page, "phynness.set({ map: 'palpation', subdivision: 1, components: true })");
    await page.waitForFunction("location.hash.startsWith('#state=')", { timeout: 5000 });
    await new Promise((resolve) => setTimeout(resolve, 700)); // the address is written when nothing moves any more
    const fragment = await ask<string>(page, 'location.hash'), force = await textAt(page, '#newtons');
    const before = opened!;
    const again = await view({ fragment });
    expect(await textAt(again, '#newtons')).toBe(force);
    expect(await ask<string>(again, 'phynness.state.map')).toBe('palpation');
    await before.page.close();
    expect(before.logged).toEqual([]);
  });

  it('saves a picture, and a surface that the validator of glTF accepts', async () => {
    const page = await view();
    await ask(page, `phynness.hold([{ node: ${front}, displacement: [0, 0, -0.01] }])`);
    const glb = await offered(page, () => page.click('#save-glb'));
    const report = await validateBytes(new Uint8Array(glb));
    expect(report.issues.messages.filter(({ severity }) => severity < 2)).toEqual([]);
    const { nodes: [body], meshes: [mesh] } = JSON.parse(glb.subarray(20, 20 + glb.readUInt32LE(12)).toString()) as {
      nodes: { extras: { tools: { nodes: number[]; displacement_m: V3 }[] } }[];
      meshes: { primitives: { targets: unknown[] }[]; extras: { targetNames: string[] } }[];
    };
    expect(body!.extras.tools).toMatchObject([{ displacement_m: [0, 0, -0.01] }]);
    expect(body!.extras.tools[0]!.nodes).toContain(front);
    expect(mesh!.extras.targetNames).toEqual(['rest']);
    expect(mesh!.primitives[0]!.targets.length).toBe(1);
    const png = await offered(page, () => page.click('#save-png'));
    expect(png.subarray(1, 4).toString()).toBe('PNG');
    expect(png.readUInt32BE(16)).toBeGreaterThan(600); // pixels across
  });

  it('takes a model that is dropped on it, and refuses a damaged one with its reason and byte', async () => {
    const page = await view(), text = readFileSync(join(built.model, 'model.txt'), 'utf8');
    const drop = (content: string) => page.evaluate((content) => {
      const data = new DataTransfer();
      data.items.add(new File([content], 'model.txt', { type: 'text/plain' }));
      window.dispatchEvent(new DragEvent('drop', { dataTransfer: data, bubbles: true, cancelable: true }));
    }, content);
    const problemOf = async (content: string) => {
      await ask(page, "document.getElementById('problem').textContent = ''");
      await drop(content);
      await page.waitForFunction("document.getElementById('problem').textContent !== ''", { timeout: 5000 });
      return textAt(page, '#problem');
    };
    expect(await problemOf(`${text.slice(0, 5000)}7${text.slice(5001)}`)).toMatch(/checksum/);
    const cut = await problemOf(sealed(text.slice(0, 5000).replace(/.*$/, '')));
    const byte = Number(/number ([\d,]+)/.exec(cut)?.[1]?.replaceAll(',', ''));
    expect(byte).toBeGreaterThan(4800);
    expect(byte).toBeLessThanOrEqual(5001);
    await drop(titled(text, 'Another organ'));
    await page.waitForFunction("document.getElementById('title').textContent === 'Another organ'", { timeout: 5000 });
    expect(await ask<boolean>(page, "document.getElementById('problem').hidden")).toBe(true);
  });

  it('shows hostile texts as texts', async () => {
    const hostile = `</script><script>alert(1)</script><img src=x onerror=alert(2)> "quotes' \u202Egnp`;
    const text = titled(readFileSync(join(built.model, 'model.txt'), 'utf8'), hostile);
    const model = join(folder, 'hostile'), file = join(folder, 'hostile.html');
    writeModel(model, text);
    phynness('view', model, '-o', file);
    const page = await view({}, file);
    expect(await textAt(page, '#title')).toBe(hostile.replace('\u202E', '\\u{202e}'));
    expect(await ask<number>(page, "document.querySelectorAll('img').length")).toBe(0);
    expect(await ask<number>(page, "document.querySelectorAll('script').length")).toBe(2);
  });

  for (const [what, width, height] of [['a desk', 1280, 800], ['a phone', 390, 844]] as const)
    it(`can be used by everybody on ${what}`, async () => {
      const page = await view({ width, height });
      await ask(page, `phynness.hold([{ node: ${front}, displacement: [0, 0, -0.01] }])`);
      await page.evaluate(axe.source);
      const { violations } = (await ask(page, 'axe.run()')) as { violations: { impact: string; id: string; help: string; nodes: { html: string }[] }[] };
      expect(violations.filter(({ impact }) => impact === 'serious' || impact === 'critical').map(({ id, help, nodes }) => [id, help, nodes[0]!.html])).toEqual([]);
      expect(await ask<number>(page, 'document.documentElement.scrollWidth')).toBeLessThanOrEqual(width);
    });
});

function writeModel(to: string, model: string): void {
  mkdirSync(to, { recursive: true });
  writeFileSync(join(to, 'model.txt'), model);
  copyFileSync(join(built.model, 'mesh.txt'), join(to, 'mesh.txt'));
}

/** A model's text with the checksum of what it holds: 64-bit FNV-1a (formats/model.md). */
function sealed(text: string): string {
  let hash = 0xcbf29ce484222325n;
  for (const byte of Buffer.from(text)) hash = ((hash ^ BigInt(byte)) * 0x100000001b3n) & 0xffffffffffffffffn;
  return `${text}checksum ${hash.toString(16).padStart(16, '0')}\n`;
}
const titled = (text: string, title: string): string =>
  sealed(text.slice(0, text.lastIndexOf('checksum ')).replace(/^title .*$/m, () => `title ${title}`));
