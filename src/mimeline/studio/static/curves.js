// The channels of an interval as curves, with a line that goes with the picture.

import uPlot from "./vendor/uplot.js";
import { element } from "./ground.js";

const HEIGHT = 62; // in px, before the page is laid out
const QUARTERS = [0.25, 0.5, 0.75, 1]; // of a channel's full range, each a hairline
const LINES = ["--line-a", "--line-b", "--line-c"];

const css = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

export const lineOf = (place) => css(LINES[place % LINES.length]);

export class Curves {
  /** box: what they fill the width of. top: the scale's end. looked(frame): a frame that is pointed
   * at, null when no longer. */
  constructor(box, exemplar, channels, top, looked) {
    const { from, to, start, end, fps } = exemplar;
    const frames = Array.from({ length: to - from }, (_, at) => from + at);
    const seconds = frames.filter((frame) => Math.floor(frame / fps) !== Math.floor((frame - 1) / fps));
    this.box = box;
    this.line = element("i", "now");
    this.plot = new uPlot({
      width: box.clientWidth || 160,
      height: box.clientHeight || HEIGHT,
      padding: [4, 0, 2, 0],
      legend: { show: false },
      cursor: { y: false, points: { show: false }, drag: { x: false, y: false, setScale: false } },
      scales: { x: { time: false, range: [from, to - 1] }, y: { range: [0, top] } },
      axes: [
        { size: 0, splits: () => seconds, values: () => [], grid: { stroke: css("--rule"), width: 1 }, ticks: { show: false } },
        { size: 0, splits: () => QUARTERS.filter((at) => at < top), values: () => [], grid: { stroke: css("--rule"), width: 1 }, ticks: { show: false } },
      ],
      series: [{}, ...channels.map((channel, place) => ({
        label: channel, stroke: lineOf(place), width: 1, alpha: 0.75, points: { show: false }, spanGaps: false,
      }))],
      hooks: {
        drawClear: [(plot) => shade(plot, start, end)],
        draw: [(plot) => channels.forEach((channel, place) => {
          level(plot, start, end, mean(exemplar.curves[channel].slice(start - from, end - from)), lineOf(place));
        })],
        setCursor: [(plot) => looked(plot.cursor.left >= 0 ? frames[plot.cursor.idx] ?? null : null)],
      },
    }, [frames, ...channels.map((channel) => exemplar.curves[channel])], box);
    this.plot.over.append(element("i", "scale", element("small", "", String(Number(top.toFixed(2)))), element("small", "", "0")), this.line);
    this.seen = new ResizeObserver(() => this.plot.setSize({ width: box.clientWidth, height: box.clientHeight }));
    this.seen.observe(box);
  }

  show(frame) {
    this.line.style.transform = `translateX(${this.plot.valToPos(frame, "x")}px)`;
  }

  remove() {
    this.seen.disconnect();
    this.plot.destroy();
  }
}

/** The interval against what is around it. */
function shade(plot, start, end) {
  const { ctx, bbox } = plot;
  const [x0, x1] = [start, end - 1].map((frame) => plot.valToPos(frame, "x", true));
  ctx.fillStyle = css("--interval");
  ctx.fillRect(x0, bbox.top, Math.max(2, x1 - x0), bbox.height);
}

/** The mean over the interval: a curve that trembles hides how high it is on the whole. */
function level(plot, start, end, value, colour) {
  if (value === null) return;
  const { ctx } = plot;
  const [x0, x1] = [start, end - 1].map((frame) => plot.valToPos(frame, "x", true));
  const y = plot.valToPos(value, "y", true);
  ctx.save();
  ctx.globalAlpha = 0.85;
  ctx.strokeStyle = colour;
  ctx.lineWidth = 3 * devicePixelRatio;
  ctx.beginPath();
  ctx.moveTo(x0, y);
  ctx.lineTo(Math.max(x0 + 2, x1), y);
  ctx.stroke();
  ctx.restore();
}

/** Of the values that there are; null: there are none. */
function mean(values) {
  const known = values.filter((value) => value !== null);
  return known.length ? known.reduce((sum, value) => sum + value, 0) / known.length : null;
}
