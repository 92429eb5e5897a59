// Path tracing of the view, laid over the live picture with a border between them that can be moved.

let tracing = null; // the socket
let shot = null; // the question that is traced
let later = 0; // timer
let tracedFacts = null;
let pictures = []; // traced, difference
let border = 0.5; // where the traced picture begins, as a share of the width
const measured = { relative_error: "relative error", rel_mse: "relMSE", delta_e_2000: "\u0394E2000", flip: "FLIP" };

// A question without what is only shown.
const sight = (q) => JSON.stringify({ ...q, id: 0, exposure: null, noise: null });

// The view has changed: trace the new one, once it stands still.
function retrace() {
  clearTimeout(later);
  $("traced").hidden = true;
  later = setTimeout(() => { if (tracing) { stopTracing(); trace(); } }, 400);
}

function stopTracing() {
  clearTimeout(later);
  if (tracing) { tracing.onclose = null; tracing.close(); }
  tracing = null;
  $("trace").textContent = "Path-trace this view";
}

function hideTruth() {
  stopTracing();
  shot = null;
  pictures = [];
  for (const id of ["traced", "wipe", "live-caption", "truth-caption", "hide-truth", "measures", "withheld"]) $(id).hidden = true;
  $("trace-state").textContent = "";
}

function trace() {
  if (tracing) { stopTracing(); return; }
  $("measures").hidden = true;
  $("trace").textContent = "Stop tracing";
  $("trace-state").textContent = "tracing the first paths";
  document.body.dataset.paths = 0;
  pictures = [];
  const own = new WebSocket(socketUrl("/trace"));
  tracing = own;
  own.binaryType = "arraybuffer";
  let next = [];
  own.onopen = () => {
    shot = question();
    ask(); // both pictures of one size
    own.send(JSON.stringify({ begin: shot }));
  };
  own.onmessage = ({ data }) => {
    if (own !== tracing) return;
    if (typeof data === "string") {
      const message = JSON.parse(data);
      if (message.error) { $("trace-state").textContent = message.error; stopTracing(); return; }
      tracedFacts = message;
      next = [];
      return;
    }
    next.push(data);
    if (next.length < 2) return;
    if (tracedFacts.id === shot.id) {
      pictures = next;
      showTraced();
      tellMeasures(tracedFacts);
      document.body.dataset.paths = tracedFacts.paths;
    }
    if (tracedFacts.paths < 4096) {
      shot.exposure = exposure;
      own.send(JSON.stringify({ next: exposure }));
    }
    else stopTracing();
  };
  own.onclose = () => { if (own === tracing) stopTracing(); };
}

function showTraced() {
  if (pictures.length < 2) return;
  const difference = $("difference").checked;
  for (const id of ["traced", "wipe", "live-caption", "truth-caption", "hide-truth"]) $(id).hidden = false;
  show($("traced"), tracedFacts.size, pictures[difference ? 1 : 0]);
  setBorder(border);
  const full = (100 * tracedFacts.full_difference).toFixed(0);
  $("truth-caption").textContent = difference
    ? `difference: red too bright, blue too dark, full colour at ${full} %`
    : `path traced, ${tracedFacts.paths} paths a pixel`;
}

function setBorder(share) {
  border = clamp(share, 0, 1);
  $("traced").style.clipPath = `inset(0 0 0 ${100 * border}%)`;
  $("wipe").style.left = `${100 * border}%`;
  $("wipe").setAttribute("aria-valuenow", Math.round(100 * border));
}

$("wipe").addEventListener("pointerdown", (event) => { $("wipe").setPointerCapture(event.pointerId); event.preventDefault(); $("wipe").focus(); });
$("wipe").addEventListener("pointermove", (event) => {
  if (!event.buttons) return;
  const box = $("frame").getBoundingClientRect();
  setBorder((event.clientX - box.left) / box.width);
});
$("wipe").addEventListener("keydown", (event) => {
  const by = { ArrowLeft: -0.02, ArrowRight: 0.02, PageDown: -0.2, PageUp: 0.2, Home: -1, End: 1 }[event.key];
  if (by === undefined) return;
  setBorder(border + by);
  event.preventDefault();
  event.stopPropagation();
});

// A figure with its uncertainty, or that the traced picture is too noisy to tell it.
function figure(m) {
  const percent = m.name === "relative_error" ? 100 : 1;
  const number = (x) => Number((percent * x).toPrecision(2));
  if (!m.is_known) return "\u2014";
  const value = Number((percent * m.value).toPrecision(3));
  return `${value} \u00b1 ${number(m.uncertainty)}${percent > 1 ? " %" : ""}`;
}

function tellMeasures(f) {
  $("trace-state").textContent = `${f.paths} paths a pixel in ${f.seconds.toFixed(1)} s`;
  if (!f.measures) return;
  $("measures").hidden = false;
  const rows = f.measures.filter((m) => m.name in measured).map((m) => {
    const row = document.createElement("tr");
    const cells = [measured[m.name], figure(m)];
    row.append(...cells.map((text) => Object.assign(document.createElement("td"), { textContent: text })));
    row.title = m.definition;
    row.dataset.known = m.is_known;
    return row;
  });
  $("measures").tBodies[0].replaceChildren(...rows);
  $("withheld").hidden = f.measures.every((m) => m.is_known);
}
