// Claims, in a real browser: the report of `phynness validate` draws its body and charts; a click on a worst case shows
// it beside the finite elements; errors between nodes are drawn side by side as coloured discs; it says so if scripts are turned off; nothing is logged, requested or executed from the
// texts in it.
import { readFileSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import axe from 'axe-core';
import type { Browser, Page } from 'puppeteer-core';
import { afterAll, afterEach, beforeAll, describe, expect, it } from 'vitest';
import { browserName, built, drawn, folder, open, phynness, pixels, start, type Opened } from './browser.js';

const report = join(folder, 'report.html'), hostile = '</script><script>alert(1)</script><img src=x onerror=alert(2)>';
let browser: Browser, opened: Opened | null = null;

beforeAll(async () => {
  const scene = join(folder, 'scene.toml');
  writeFileSync(scene, readFileSync(join(built.source, 'examples/model/scene.toml'), 'utf8').replace(/^title = .*$/m, `title = "${hostile}"`));
  phynness('validate', scene, built.model, '--probes', '40', '--points', '8', '--report', report);
  browser = await start();
});
afterAll(async () => browser?.close());
afterEach(async () => {
  const now = opened;
  opened = null;
  if (!now) return;
  await now.page.close();
  expect(now.logged).toEqual([]);
  expect(now.requested).toEqual([]);
});
const ask = <T>(page: Page, expression: string): Promise<T> => page.evaluate(expression) as Promise<T>;
async function view(options: Parameters<typeof open>[2] = {}): Promise<Page> {
  opened = await open(browser, report, { ready: 'globalThis.phynnessReport', ...options });
  return opened.page;
}

describe(`the report in ${browserName}`, () => {
  it('draws charts and the body, and shows a worst case by a click', async () => {
    const page = await view();
    const parts = await ask<number[]>(page, "['.chart', '.chart canvas', 'section', '.wide > table', 'details'].map((part) => document.querySelectorAll(part).length)");
    expect(parts).toEqual([parts[1], expect.any(Number), 7, 5, 1]);
    expect(parts[0]).toBeGreaterThanOrEqual(2);
    expect(await ask<string>(page, "document.querySelector('li').textContent")).toMatch(/^Error of forces: the model is /);
    expect(await ask<string>(page, "document.querySelectorAll('li')[1].textContent")).toMatch(/^Worst node: the force is off by/);
    expect(await ask<boolean>(page, "document.querySelector('table').getBoundingClientRect().bottom < document.querySelector('h2').getBoundingClientRect().top")).toBe(true);
    await page.click('[data-case="0"] button');
    await drawn(page);
    const boxes = await ask<{ x: number; y: number; width: number; height: number }[]>(page,
      "[...document.querySelectorAll('.pane:not([hidden]) canvas')].map((canvas) => canvas.getBoundingClientRect().toJSON())");
    expect(boxes.length).toBe(2);
    expect(await ask<string>(page, "document.querySelectorAll('.pane figcaption')[1].textContent")).toMatch(/^Model, node \d+ displaced by/);
    const picture = await pixels(page);
    for (const box of boxes) {
      const seen: number[] = [];
      for (let y = Math.max(2, box.y + 2); y < Math.min(picture.height, box.y + box.height) - 2; y += 5)
        for (let x = box.x + 2; x < box.x + box.width - 2; x += 5) seen.push(picture.at(x, y).reduce((a, b) => a + b, 0) / 3);
      const mean = seen.reduce((a, b) => a + b, 0) / seen.length;
      expect(Math.sqrt(seen.reduce((a, b) => a + (b - mean) ** 2, 0) / seen.length)).toBeGreaterThan(15); // empty: below 3
    }
  });
  it('draws the errors between nodes as discs, of all predictors on one scale', async () => {
    const page = await view(), shown = "document.querySelectorAll('.pane:not([hidden])').length";
    expect(await ask<number>(page, shown)).toBe(1);
    const value = await ask<string>(page, "[...document.querySelectorAll('#body option')].find((o) => o.text === 'Mean error of the force between nodes').value");
    await page.evaluate(`phynnessReport.show('${value}'); phynnessReport.scrollTo()`);
    expect(await ask<string>(page, "document.querySelector('.legend').textContent")).toMatch(/^Mean error of the force between nodes \[%\]0.1110100.*Red ring/);
    const picture = await pixels(page);
    const panes = await ask<{ caption: string; x: number; y: number; width: number; height: number }[]>(page,
      "[...document.querySelectorAll('.pane:not([hidden])')].map((pane) => ({ ...pane.querySelector('canvas').getBoundingClientRect().toJSON(), caption: pane.textContent }))");
    expect(panes.map(({ caption }) => caption.replace(/: .*/, ''))).toEqual(['Linear predictor', 'Model']);
    for (const { x, y, width, height } of panes) {
      let coloured = 0;
      for (let row = Math.max(2, y); row < Math.min(picture.height, y + height) - 2; row += 2)
        for (let column = x + 2; column < x + width - 2; column += 2) {
          const colour = picture.at(column, row);
          coloured += Number(Math.max(...colour) - Math.min(...colour) > 60);
        }
      expect(coloured).toBeGreaterThan(20); // the body and its background are grey
    }
  });
  // The width of letters differs between browsers.
  it.skipIf(browserName !== 'chromium')('shows all columns at 1,200 pixels, and scrolls nothing but tables at 400', async () => {
    const page = await view({ width: 1200 });
    await page.evaluate("document.querySelectorAll('details').forEach((folded) => { folded.open = true; })");
    expect(await ask<string[]>(page,
      "[...document.querySelectorAll('.wide')].filter((e) => e.scrollWidth > e.clientWidth).map((e) => e.textContent.slice(0, 40))")).toEqual([]);
    await page.setViewport({ width: 400, height: 800 });
    // Charts follow the width of the window after the layout. The wait ends in an error if one stays wider.
    await page.waitForFunction('document.documentElement.scrollWidth === 400');
  });
  // Firefox has no command for it in WebDriver BiDi.
  it.skipIf(browserName === 'firefox')('says that it needs scripts where they are turned off', async () => {
    const page = await view({ scripts: false });
    const text = await page.$eval('body', (body) => (body as HTMLElement).innerText).catch(() => '');
    // Some browsers evaluate nothing in a page without scripts.
    if (text !== '') expect(text).toMatch(/scripts are turned off/);
  });
  it('shows hostile texts as texts, and can be used by everybody', async () => {
    const page = await view({ width: 390, height: 844 });
    expect(await ask<string>(page, "document.querySelector('h1').textContent")).toBe(hostile);
    expect(await ask<number>(page, "document.querySelectorAll('img').length")).toBe(0);
    await page.evaluate(axe.source);
    const { violations } = (await ask(page, 'axe.run()')) as { violations: { impact: string; id: string; nodes: { html: string }[] }[] };
    expect(violations.filter(({ impact }) => impact === 'serious' || impact === 'critical').map(({ id, nodes }) => [id, nodes[0]!.html])).toEqual([]);
  });
});
