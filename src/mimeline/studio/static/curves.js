// The channels of an interval as curves, with a line that goes with the picture.

import uPlot from "./vendor/uplot.js";
import { element } from "./ground.js";

const HEIGHT = 62; // in px, before the page is laid out
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
        { show: false },
      ],
      series: [{}, ...channels.map((channel, place) => ({
        label: channel, stroke: lineOf(place), width: 1.5, points: { show: false }, spanGaps: false,
      }))],
      hooks: {
        drawClear: [(plot) => shade(plot, start, end)],
        setCursor: [(plot) => looked(plot.cursor.left >= 0 ? frames[plot.cursor.idx] ?? null : null)],
      },
    }, [frames, ...channels.map((channel) => exemplar.curves[channel])], box);
    this.plot.over.append(this.line);
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
  ctx.fillStyle = css("--lifted");
  ctx.fillRect(x0, bbox.top, Math.max(2, x1 - x0), bbox.height);
}
