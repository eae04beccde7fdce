// The figure in which recording and reading are chosen, and which zooms. Without a script, and on paper, a drawing stands there.
const traces = document.getElementById("traces");
if (traces) {
  const data = JSON.parse(document.getElementById("traces-data").textContent);
  const names = ["recorded", "nominal simulator", "explained simulator"];
  const colours = ["--recorded", "--nominal", "--explained"];
  const noSample = -32768;
  const [recordings, readings] = traces.querySelectorAll("select");
  const [errors, panel] = [traces.querySelector(".errors"), traces.querySelector(".panels")];
  const colour = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
  const bytes = (text) => Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0)).buffer;
  let plots = [], whole = [0, 1];

  const option = (list, text, index) => list.append(new Option(text, index));
  data.recordings.forEach((one, index) => option(recordings, `${one.name} (${one.role})`, index));
  const listReadings = () => {
    const kept = readings.value;
    readings.replaceChildren();
    data.recordings[recordings.value].readings.forEach((one, index) => option(readings, one.name, index));
    readings.value = readings.options[kept] ? kept : 0;
  };

  const show = (low, high) => {
    const [first, last] = whole;
    const width = Math.min(high - low, last - first);
    const from = Math.min(Math.max(low, first), last - width);
    for (const plot of plots) plot.setScale("x", { min: from, max: from + width });
  };
  const settings = (label, height, lines) => ({
    width: panel.clientWidth,
    height,
    scales: { x: { time: false } },
    cursor: { sync: { key: "traces", setSeries: false }, drag: { setScale: true, x: true, y: false } },
    hooks: { setScale: [(plot, key) => {
      // A part that was chosen in one panel is shown in the other too.
      const { min, max } = plot.scales.x;
      for (const other of plots) {
        if (key === "x" && other !== plot && (other.scales.x.min !== min || other.scales.x.max !== max)) {
          other.setScale("x", { min, max });
        }
      }
    }] },
    axes: [
      { stroke: () => colour("--pale"), grid: { stroke: () => colour("--rule"), width: 1 }, font: "12px system-ui", label: "time (s)",
        labelFont: "12px system-ui", labelSize: 18, size: 30 },
      { stroke: () => colour("--pale"), grid: { stroke: () => colour("--rule"), width: 1 }, font: "12px system-ui", label,
        labelFont: "12px system-ui", labelSize: 18, size: 56 },
    ],
    series: [{ label: "time (s)", value: (_, x) => (x == null ? "–" : x.toFixed(3)) }, ...lines.map((line) => ({
      label: names[line], stroke: () => colour(colours[line]), width: line === 0 ? 2.5 : 1.5, points: { show: false },
      dash: line === 2 ? [6, 3] : undefined, value: (_, y) => (y == null ? "–" : y.toPrecision(4)),
    }))],
    legend: { markers: { stroke: (_, index) => `var(${colours[lines[index - 1]]})`, fill: (_, index) => `var(${colours[lines[index - 1]]})` } },
  });

  const draw = () => {
    const recording = data.recordings[recordings.value];
    const reading = recording.readings[readings.value];
    const time = Array.from(new Float32Array(bytes(recording.time)));
    const series = reading.values.map((text) => Array.from(new Int16Array(bytes(text)), (level) =>
      level === noSample ? null : reading.low + level * reading.step));
    const missed = series.slice(1).map((values) => values.map((value, row) =>
      value === null || series[0][row] === null ? null : value - series[0][row]));
    const unit = reading.unit ? ` (${reading.unit})` : "";
    for (const plot of plots) plot.destroy();
    plots = [];
    const made = [
      new uPlot(settings(`${reading.name}${unit}`, 260, [0, 1, 2]), [time, ...series], panel),
      new uPlot(settings(`error${unit}`, 180, [1, 2]), [time, ...missed], panel),
    ];
    whole = [time[0], time[time.length - 1]];
    plots = made;
    errors.textContent = reading.errors;
  };

  const moves = { in: [0.25, 0.75], out: [-0.5, 1.5], earlier: [-0.5, 0.5], later: [0.5, 1.5] };
  for (const button of traces.querySelectorAll("[data-move]")) {
    button.addEventListener("click", () => {
      const { min, max } = plots[0].scales.x;
      const part = moves[button.dataset.move];
      if (part) show(min + part[0] * (max - min), min + part[1] * (max - min));
      else show(...whole);
    });
  }
  recordings.addEventListener("change", () => { listReadings(); draw(); });
  readings.addEventListener("change", draw);
  traces.hidden = false;
  document.documentElement.classList.add("live");
  recordings.value = data.first[0];
  listReadings();
  readings.value = data.first[1];
  draw();
  new ResizeObserver(() => plots.forEach((plot) => plot.setSize({ width: panel.clientWidth, height: plot.height }))).observe(panel);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => plots.forEach((plot) => plot.redraw()));
}
