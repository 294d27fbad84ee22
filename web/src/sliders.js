// A slider a muscle, the two sides beside each other as they are seen from the front: the subject's right on the left.

import { element } from './dom.js';

const spoken = (name) => name.replaceAll('_', ' ');

/** Fills `parent` with the sliders of `result`; `moved(muscle, value)` hears of each. */
export class Sliders {
  constructor(parent, result, bothSides, moved) {
    Object.assign(this, { result });
    this.inputs = [];
    const { muscles } = result.face;
    const stems = [...new Set(muscles.map((m) => m.stem))];
    parent.replaceChildren(...stems.map((stem) => {
      const of = (side) => muscles.findIndex((m) => m.stem === stem && m.side === side);
      const sides = ['right', 'left', 'both'].map(of);
      const row = sides.filter((m) => m >= 0);
      const slider = (m) => this.slider(m, (value) => {
        const other = bothSides.checked ? row : [m];
        other.forEach((k) => moved(k, value));
      });
      return element('div', { class: 'muscle', role: 'group', 'aria-label': spoken(stem) },
        element('h4', {}, spoken(stem)),
        element('div', { class: row.length > 1 ? 'pair' : 'pair single' }, ...row.map(slider)));
    }));
  }

  slider(m, moved) {
    const { result } = this;
    const { name, side } = result.face.muscles[m];
    const answer = result.answer.activation[m];
    const interval = result.json.intervals[name];
    const id = `slider-${m}`;
    const said = side === 'both' ? 'whole muscle' : side;
    const open = interval ? `, from ${percent(interval[0])} to ${percent(interval[1])} by the data` : '';
    const input = element('input', {
      type: 'range', id, min: 0, max: 100, step: 1, disabled: result.canSuperpose ? null : '',
      'aria-label': `${spoken(name.replace(/_[lr]$/, ''))}, ${said}, per cent; answer ${percent(answer)}${open}`,
    });
    const output = element('output', { for: id });
    input.addEventListener('input', () => moved(input.valueAsNumber / 100));
    this.inputs[m] = { input, output };
    const band = element('div', { class: 'band', 'aria-hidden': 'true' });
    if (interval) {
      const range = element('i', {});
      range.style.left = percent(interval[0]);
      range.style.width = percent(interval[1] - interval[0]);
      band.append(range);
    }
    const tick = element('b', {});
    tick.style.left = percent(answer);
    band.append(tick);
    return element('div', { class: 'slider' }, element('label', { for: id }, said, output), input, band);
  }

  /** Puts the sliders where the face is. */
  show() {
    this.inputs.forEach(({ input, output }, m) => {
      const a = this.result.activation[m];
      if (document.activeElement !== input || Math.abs(input.valueAsNumber / 100 - a) > 0.006) input.value = Math.round(100 * a);
      output.textContent = percent(a);
      input.setAttribute('aria-valuetext', `${Math.round(100 * a)} per cent`);
    });
  }
}

function percent(share) {
  return `${Math.round(100 * share)} %`.replace(' %', '%');
}
