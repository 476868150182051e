// A small picture of a channel, with what counts of it and what was found in it.

import { svg } from "./dom.js";
import { num, unitOf } from "./format.js";

const WIDE = 200;

export function picture(channel, { span, begin = 0, window = null, marks = [] }) {
  const height = channel.high - channel.low || 1;
  const at = (t) => ((t - begin) / (span || 1)) * WIDE;
  const root = svg("svg", { viewBox: `0 0 ${WIDE} 26`, preserveAspectRatio: "none", role: "img", "aria-label": `${channel.name} ${num(channel.low)} … ${num(channel.high)} ${unitOf(channel.unit)}` });
  if (window) root.append(svg("rect", { x: at(window[0]), y: 0, height: 26, width: Math.max(at(window[1]) - at(window[0]), 0) }));
  for (const mark of marks.filter((own) => !own.channel || own.channel === channel.name)) {
    root.append(svg("rect", { class: `mark ${mark.severity}`, x: at(mark.from), y: 0, height: 26, width: Math.max(at(mark.to) - at(mark.from), 1) }));
  }
  let pen = "M";
  const d = channel.values.map((value, i) => {
    if (value === null) {
      pen = "M";
      return "";
    }
    const step = `${pen}${at(channel.t[i]).toFixed(1)} ${(24 - ((value - channel.low) / height) * 22).toFixed(1)}`;
    pen = "L";
    return step;
  }).join("");
  root.append(svg("path", { d }));
  return root;
}
