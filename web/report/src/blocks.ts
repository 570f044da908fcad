// The elements of a report, from its data. Texts come from scenes and models, so they are set as texts only.
import { plain } from '../../shared/src/numbers.js';
import { drawChart } from './charts.js';
import type { Block, Cell, Section } from './data.js';

const readable = (text: string): string => plain(text, Infinity);

function made<K extends keyof HTMLElementTagNameMap>(tag: K, className: string, ...content: (Node | string)[]): HTMLElementTagNameMap[K] {
  const element = document.createElement(tag);
  if (className) element.className = className;
  element.append(...content.map((part) => (typeof part === 'string' ? readable(part) : part)));
  return element;
}

/** Lines must not be broken after the minus of a number, and sentences among numbers are. */
function classOf(text: string, words: boolean): string {
  if (words) return /^\d\S*$/.test(text) ? 'one-line' : '';
  return /[a-z] [a-z]+ [a-z]/i.test(text) ? 'sentence' : '';
}

function tableOf(rows: readonly (readonly Cell[])[], words: boolean): HTMLElement {
  const table = made('table', words ? 'words' : ''), head = table.createTHead(), body = table.createTBody();
  rows.forEach((row, r) => {
    const line = (r === 0 ? head : body).insertRow();
    row.forEach((cell, column) => {
      const text = typeof cell === 'string' ? cell : cell.text;
      const element = made(r === 0 ? 'th' : 'td', r > 0 && column > 0 ? classOf(text, words) : '', text);
      if (typeof cell !== 'string') element.dataset['case'] = `${cell.case}`;
      line.append(element);
    });
  });
  const wide = made('div', 'wide', table);
  wide.tabIndex = 0;
  return wide;
}

function elementOf(block: Block): HTMLElement {
  if (block.warning !== undefined) return made('p', 'warning', block.warning);
  if (block.remark !== undefined) return made('p', 'key', block.remark);
  if (block.list) return made('ul', '', ...block.list.map(([title, sentence]) => made('li', '', made('strong', '', title), `: ${sentence}`)));
  if (block.table) return tableOf(block.table, block.words ?? false);
  if (block.charts)
    return made('div', 'plots', ...block.charts.map((chart) => {
      const place = made('div', 'chart');
      const empty = chart.curves.every(({ x }) => x.length === 0);
      if (empty) place.append('No data.');
      // The width of a chart is that of its element on the page.
      else queueMicrotask(() => drawChart(place, chart));
      return made('figure', '', place, ...(chart.caption ? [made('figcaption', '', chart.caption)] : []));
    }));
  if (block.pictures)
    return made('div', 'plots', ...block.pictures.map(({ svg, caption }) => {
      const image = new Image();
      image.src = `data:image/svg+xml,${encodeURIComponent(svg)}`;
      image.alt = caption;
      return made('figure', '', image, made('figcaption', '', caption));
    }));
  if (block.body) {
    const place = made('div', '');
    place.id = 'body';
    return place;
  }
  return made('p', '', block.text ?? '');
}

/** Appends a section to the page. */
export function drawSection(section: Section): void {
  const blocks = section.blocks.map((block) =>
    block.folded === undefined ? elementOf(block) : made('details', '', made('summary', '', block.folded), elementOf(block)));
  document.body.append(made('section', '', ...(section.title ? [made('h2', '', section.title)] : []), ...blocks));
}
export const drawTitle = (title: string): void => {
  document.title = readable(title);
  document.body.append(made('h1', '', title));
};
