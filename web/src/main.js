// The page: results on the stage, moved by what the controls say.

import { readPage } from './data.js';
import { byId, element, press, toggleButton } from './dom.js';
import { Drawn, Face, linearColours, muscleColour } from './drawn.js';
import * as fields from './fields.js';
import { Result } from './result.js';
import { Sliders } from './sliders.js';
import { Stage, VIEWS } from './stage.js';

/** Seconds that the way from rest to an answer takes, and the least that a sequence does. */
const LOADING_S = 2, LEAST_S = 1.5;

const MAPS = {
  none: { name: 'none: skin' },
  displacement: { name: 'displacement, mm', title: 'Displacement', unit: 'mm', of: fields.displacement, share: 1 },
  stretch: {
    name: 'strain of the skin, %', title: 'Strain of the skin', unit: '%', of: fields.stretch, share: 0.99,
    note: 'greatest principal, logarithmic, in its plane',
  },
  asymmetry: {
    name: 'left-right asymmetry, mm', title: 'Asymmetry', unit: 'mm', of: fields.asymmetry, share: 1,
    note: 'from the mirror image of the other side',
  },
  pressure: {
    name: 'contact pressure, kPa', title: 'Contact pressure', unit: 'kPa', of: fields.pressure, share: 0.995,
    note: 'on the areas of rest; look from inside, without teeth',
  },
};

class Report {
  constructor({ page, arrays }) {
    this.colours = linearColours(page.colours);
    this.css = page.colours.map((c) => `rgb(${c})`).join(',');
    const faces = page.faces.map((face) => new Face(face, arrays));
    this.results = page.results.map((json) => new Result(json, faces[json.face], arrays));
    this.drawn = this.results.map((result) => new Drawn(result));
    this.acted = this.results.map(() => true);
    this.share = 1;
    this.map = 'none';
    this.stale = true;
    this.stage = new Stage(byId('canvas'), this.drawn, () => this.draw());
    this.largest = {};
    this.makeViews();
    this.makeToggles();
    this.makeSides();
    this.makePanes();
    this.makeSliders();
    this.makePlayer();
    this.listen();
    this.themed();
    this.showMoment(this.results[0].start);
  }

  tell(text) {
    byId('told').textContent = text;
  }

  /** Draws at the next frame. */
  draw() {
    if (this.asked) return;
    this.asked = requestAnimationFrame(() => {
      this.asked = null;
      this.refresh();
    });
  }

  /** Everything has moved. */
  move() {
    this.stale = true;
    this.draw();
  }

  refresh() {
    if (this.stale) {
      this.stale = false;
      this.drawn.forEach((drawn, k) => this.stage.shown[k] && drawn.update());
      this.colourSkins();
      this.sliders?.show();
      this.tellMoment();
    }
    this.stage.render();
    this.labelEnds();
    this.drawScale();
  }

  makeViews() {
    this.viewButtons = VIEWS.map(({ name }, k) =>
      toggleButton(name, `${name} view, key ${k + 1}`, () => this.look(k)));
    const save = element('button', { type: 'button' }, 'Save picture');
    save.addEventListener('click', () => this.save());
    byId('views').append(...this.viewButtons, save);
    this.look(0);
  }

  look(k) {
    this.stage.look(k);
    this.viewButtons.forEach((b, j) => press(b, j === k));
    this.tell(`${VIEWS[k].name} view`);
  }

  save() {
    this.stage.render();
    const link = element('a', { download: 'face.png', href: byId('canvas').toDataURL('image/png') });
    link.click();
  }

  makeToggles() {
    const parts = [['teeth', 'Teeth', true], ['bones', 'Bones', false], ['muscles', 'Muscles', false], ['markers', 'Markers', true]];
    for (const [part, name, on] of parts) {
      const there = {
        teeth: (d) => d.face.teeth.length, bones: (d) => d.face.bones.length,
        muscles: (d) => d.face.muscles.length, markers: (d) => d.result.json.markers.length,
      }[part];
      if (!this.drawn.some(there)) continue;
      const box = element('input', { type: 'checkbox', id: `show-${part}` });
      box.checked = on;
      const set = () => {
        this.drawn.forEach((d) => (d[part].visible = box.checked));
        // What the skin hides is not shown by a tick alone.
        const within = part === 'bones' || part === 'muscles';
        if (within && box.checked && byId('skin').value === 'solid') this.setSkin('veil');
        this.tellLegend();
        this.move();
      };
      box.addEventListener('change', set);
      this.drawn.forEach((d) => (d[part].visible = on));
      const dots = part === 'markers'
        ? [' (', element('i', { class: 'dot measured' }), ' measured, ', element('i', { class: 'dot model' }), ' model)'] : [];
      byId('toggles').append(element('label', { class: 'check' }, box, element('span', {}, name, ...dots)));
    }
    const choice = byId('colour');
    for (const [key, map] of Object.entries(MAPS)) {
      if (key === 'pressure' && !this.results.some((r) => r.hasPressure)) continue;
      choice.append(element('option', { value: key }, map.name));
    }
    choice.addEventListener('change', () => {
      this.map = choice.value;
      this.move();
    });
    byId('skin').addEventListener('change', () => this.setSkin(byId('skin').value));
  }

  setSkin(how) {
    byId('skin').value = how;
    for (const { skin, material, throat } of this.drawn) {
      if (throat) throat.visible = how === 'solid';
      skin.visible = how !== 'none';
      material.transparent = how === 'veil';
      material.opacity = how === 'veil' ? 0.34 : 1;
      material.depthWrite = how !== 'veil';
      material.needsUpdate = true;
    }
    this.draw();
  }

  /** Which of two results are shown, and which of them the sliders move. */
  makeSides() {
    if (this.results.length < 2) return;
    byId('sides').hidden = false;
    const choices = [['A and B', [true, true]], ['A', [true, false]], ['B', [false, true]]];
    const buttons = choices.map(([name, shown], k) =>
      toggleButton(name, name.length > 1 ? 'Both results' : `Result ${name} alone`, () => {
        this.stage.shown = shown;
        this.acted = shown;
        buttons.forEach((b, j) => press(b, j === k));
        this.stage.resize();
        this.makePanes();
        this.makeSliders();
        this.move();
      }));
    press(buttons[0], true);
    byId('side-choice').append(...buttons);
  }

  makePanes() {
    const letters = this.results.length > 1 ? ['A: ', 'B: '] : [''];
    this.ends = [];
    const panes = this.results.flatMap((result, k) => {
      if (!this.stage.shown[k]) return [];
      const [west, east] = ['west', 'east'].map((end) => element('p', { class: `end ${end}` }));
      this.ends.push([west, east]);
      const moment = element('p', {});
      result.told = moment;
      return [element('div', {}, element('h2', {}, letters[k] + result.title), moment, west, east)];
    });
    byId('panes').replaceChildren(...panes);
    byId('canvas').setAttribute('aria-label', `The face: ${this.results.filter((_, k) => this.stage.shown[k]).map((r) => r.title).join(' and ')}`);
  }

  /** The results that the controls act on. */
  get acting() {
    return this.results.filter((_, k) => this.acted[k]);
  }

  makeSliders() {
    const first = this.acting[0];
    this.sliders = new Sliders(byId('sliders'), first, byId('both-sides'), (m, value) => {
      this.stop();
      const { name } = first.face.muscles[m];
      for (const result of this.acting) {
        const own = result.face.muscles.findIndex((muscle) => muscle.name === name);
        if (own < 0 || !result.canSuperpose) continue;
        const activation = [...result.activation];
        activation[own] = value;
        result.showLinear(activation);
      }
      this.move();
    });
    const can = first.canSuperpose;
    byId('to-rest').disabled = !can;
    byId('to-answer').hidden = byId('to-rest').hidden = first.json.kind === 'track';
    byId('both-sides').parentElement.hidden = first.json.kind === 'track';
    byId('both-sides').disabled = !can;
    const parts = [];
    if (Object.keys(first.json.intervals).length) parts.push('The band below a slider is what the data leave open, the mark the answer.');
    if (first.json.kind === 'track') parts.push('The sliders show the activations of the frame.');
    else if (!can) parts.push('There is no tangent at this answer: the sliders only show the activations.');
    byId('band-hint').textContent = parts.join(' ');
    byId('notes').replaceChildren(...this.acting.flatMap((r) => r.json.notes.map((note) => element('p', {}, note))));
  }

  makePlayer() {
    byId('time').addEventListener('input', () => {
      this.stop();
      this.showMoment(byId('time').valueAsNumber / 1000);
    });
    byId('play').addEventListener('click', () => (this.playing ? this.stop() : this.play()));
    byId('to-answer').addEventListener('click', () => {
      this.stop();
      if (this.acting[0].json.kind === 'loading') this.showMoment(1);
      else this.acting.forEach((result) => result.showAnswer());
      this.move();
      this.tell('At the answer');
    });
    byId('to-rest').addEventListener('click', () => {
      this.stop();
      for (const result of this.acting) if (result.canSuperpose) result.showLinear(result.activation.map(() => 0));
      this.move();
      this.tell('All activations 0, to first order');
    });
  }

  showMoment(share) {
    this.share = share;
    this.results.forEach((result) => result.showMoment(share));
    byId('time').value = Math.round(1000 * share);
    this.move();
  }

  get duration() {
    const { json, times } = this.acting[0];
    return json.kind === 'loading' ? LOADING_S : Math.max(times.at(-1) - times[0], LEAST_S);
  }

  play() {
    if (this.share >= 1) this.share = 0;
    this.playing = { from: this.share, since: performance.now() };
    press(byId('play'), true);
    byId('play').setAttribute('aria-label', 'Pause');
    const step = (now) => {
      if (!this.playing) return;
      const speed = Number(byId('speed').value);
      const share = this.playing.from + (speed * Math.max(now - this.playing.since, 0)) / 1000 / this.duration;
      this.showMoment(Math.min(share, 1));
      if (share < 1) requestAnimationFrame(step);
      else this.stop();
    };
    requestAnimationFrame(step);
  }

  stop() {
    this.playing = null;
    press(byId('play'), false);
    byId('play').setAttribute('aria-label', 'Play');
  }

  /** Says where each face is, and how that was found. */
  tellMoment() {
    for (const result of this.results) if (result.told) result.told.textContent = said(result);
    const first = this.acting[0];
    byId('moment').textContent = first.linear ? 'moved by the sliders' : said(first);
    byId('time').setAttribute('aria-valuetext', said(first));
    byId('mode').replaceChildren(...(first.linear
      ? [element('strong', {}, 'Linear: '), 'the tangent at the answer, superposed. Nothing else comes into contact; far from the answer it is only a direction.']
      : [element('strong', {}, first.json.kind === 'track' ? 'Frames as fitted.' : 'Stored states. '), first.canSuperpose ? 'Move a slider to leave them along the tangent at the answer.' : '']));
  }

  colourSkins() {
    const map = MAPS[this.map];
    this.stage.light(Boolean(map.of));
    if (!map.of) {
      this.drawn.forEach((d) => d.colour(null));
      this.legend = null;
      this.tellLegend();
      return;
    }
    const largest = (this.largest[this.map] ??= this.largestOf(map));
    let most = 0, unknown = false;
    this.drawn.forEach((drawn, k) => {
      if (!this.stage.shown[k]) return;
      const values = map.of(drawn.result);
      unknown ||= !values;
      most = Math.max(most, drawn.colour(values, largest, this.colours));
    });
    const note = unknown && this.map === 'pressure' ? 'known only of stored states' : (map.note ?? '');
    this.legend = { ...map, largest, note, more: most > largest * 1.001 };
    this.tellLegend();
  }

  /** The end of the scale: of all results where their answers are, so that colours can be compared. */
  largestOf(map) {
    const at = (result) => {
      const there = Object.create(result);
      there.u = result.answer.u;
      there.pressure = result.answer.kpa;
      const values = map.of(there);
      return values ? fields.quantile(values, map.share) : 0;
    };
    return fields.roundUp(Math.max(...this.results.map(at)));
  }

  tellLegend() {
    const { legend } = this;
    const muscles = this.drawn[0].muscles.visible;
    byId('legend').hidden = !legend && !muscles;
    const lines = [];
    if (muscles) {
      const stops = [0, 0.01, 0.25, 0.5, 1].map((a) => `rgb(${muscleColour(a).map((x) => Math.round(255 * (x <= 0.0031308 ? 12.92 * x : 1.055 * x ** (1 / 2.4) - 0.055)))}) ${100 * a}%`);
      const bar = element('div', { class: 'bar', 'aria-hidden': 'true' });
      bar.style.cssText = `height:10px;margin:4px 0 2px;background:linear-gradient(90deg,${stops})`;
      lines.push(element('div', {}, element('strong', {}, 'Muscles: activation'), bar, ends('0 %', '100 %'), 'grey: at rest'));
    }
    byId('legend-title').textContent = legend ? `${legend.title}, ${legend.unit}` : '';
    byId('legend-bar').hidden = !legend;
    byId('legend-ends').hidden = !legend;
    if (legend) {
      byId('legend-bar').style.background = `linear-gradient(90deg,${this.css})`;
      const number = (x) => String(Number(x.toPrecision(3)));
      byId('legend-ends').replaceChildren(element('span', {}, '0'), element('span', {}, number(legend.largest / 2)), element('span', {}, `${legend.more ? '≥ ' : ''}${number(legend.largest)}`));
    }
    byId('legend-note').replaceChildren(legend?.note ?? '', ...lines);
  }

  labelEnds() {
    const [west, east] = this.stage.ends();
    for (const [w, e] of this.ends) {
      w.textContent = west;
      e.textContent = east;
    }
  }

  drawScale() {
    const perMm = this.stage.pixelsPerMm;
    const mm = [1, 2, 5, 10, 20, 50, 100].findLast((x) => x * perMm <= 110) ?? 1;
    byId('scale').style.width = `${mm * perMm}px`;
    byId('scale').firstElementChild.textContent = `${mm} mm`;
  }

  listen() {
    const keys = {
      ArrowLeft: () => this.stage.turn(-6, 0), ArrowRight: () => this.stage.turn(6, 0),
      ArrowUp: () => this.stage.turn(0, 6), ArrowDown: () => this.stage.turn(0, -6),
      '+': () => this.stage.magnify(1.15), '=': () => this.stage.magnify(1.15), '-': () => this.stage.magnify(1 / 1.15),
      ' ': () => (this.playing ? this.stop() : this.play()),
      ...Object.fromEntries(VIEWS.map((_, k) => [String(k + 1), () => this.look(k)])),
    };
    byId('canvas').addEventListener('keydown', (event) => {
      const act = keys[event.key];
      if (!act || event.ctrlKey || event.metaKey || event.altKey) return;
      event.preventDefault();
      act();
    });
    this.stage.orbit.addEventListener('start', () => this.viewButtons.forEach((b) => press(b, false)));
    window.matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => this.themed());
    window.addEventListener('beforeprint', () => {
      this.stage.resize();
      this.refresh();
    });
  }

  themed() {
    const style = getComputedStyle(document.documentElement);
    const of = (name) => style.getPropertyValue(name).trim();
    this.drawn.forEach((d) => d.colourMarkers({ measured: of('--measured'), model: of('--model'), residual: of('--ink') }));
    this.draw();
  }
}

function ends(from, to) {
  const row = element('div', {}, element('span', {}, from), element('span', {}, to));
  row.style.cssText = 'display:flex;justify-content:space-between';
  return row;
}

function said(result) {
  if (result.linear) return 'by superposition at the answer';
  const { state, between, time } = result.moment;
  if (state !== null) return result.states[state].label;
  if (result.json.kind === 'loading') return `${Math.round(100 * time)} % of the way`;
  if (result.json.kind === 'track') return `${time.toFixed(2)} s`;
  return `${time.toFixed(2)} s, between ${result.states[between[0]].label} and ${result.states[between[1]].label}`;
}

async function open() {
  try {
    const report = new Report(await readPage());
    report.refresh();
    // What a test reads; nothing on the page does.
    window.modiolusReport = {
      readyMs: performance.now(),
      positions: (k) => report.drawn[k].positions,
      results: report.results,
      drawn: report.drawn,
    };
    document.documentElement.dataset.ready = 'true';
  } catch (error) {
    const failure = byId('failure');
    failure.hidden = false;
    failure.textContent = `The face cannot be shown in three dimensions here (${error.message}). The tables below hold all figures.`;
    document.documentElement.dataset.ready = 'failed';
  }
}

open();
