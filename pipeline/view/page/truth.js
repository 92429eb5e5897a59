// Path tracing beside the live picture.

let tracing = null; // the socket
let shot = null; // the question that is traced
let later = 0; // timer
let tracedFacts = null;
let pictures = []; // traced, difference
const measured = { relative_error: "relative error", rel_mse: "relMSE", delta_e_2000: "\u0394E2000", flip: "FLIP" };

// A question without what is only shown.
const sight = (q) => JSON.stringify({ ...q, id: 0, exposure: null });

// The view has changed: trace the new one, once it stands still.
function retrace() {
  clearTimeout(later);
  later = setTimeout(() => { if (tracing) { stopTracing(); trace(); } }, 400);
}

function stopTracing() {
  clearTimeout(later);
  if (tracing) { tracing.onclose = null; tracing.close(); }
  tracing = null;
  $("trace").textContent = "Path-trace this view";
}

function trace() {
  if (tracing) { stopTracing(); return; }
  $("truth").hidden = false;
  $("measures").hidden = true;
  $("trace").textContent = "Stop tracing";
  $("trace-state").textContent = "tracing the first paths";
  pictures = [];
  const own = new WebSocket(socketUrl("/trace"));
  tracing = own;
  own.binaryType = "arraybuffer";
  let next = [];
  shot = null;
  own.onopen = () => {
    // the view as it is once the second picture has taken its place
    requestAnimationFrame(() => { shot = question(); ask(); own.send(JSON.stringify({ begin: shot })); });
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
    pictures = next;
    showTraced();
    tellMeasures(tracedFacts);
    document.body.dataset.paths = tracedFacts.paths;
    if (tracedFacts.paths < 4096) own.send('"next"');
    else stopTracing();
  };
  own.onclose = () => { if (own === tracing) stopTracing(); };
}

function showTraced() {
  if (pictures.length < 2) return;
  const difference = $("difference").checked;
  show($("traced"), tracedFacts.size, pictures[difference ? 1 : 0]);
  const full = (100 * tracedFacts.full_difference).toFixed(0);
  $("truth-caption").textContent = difference
    ? `nets minus traced, luminance: red too bright, blue too dark, full colour at ${full} %`
    : `path traced, ${tracedFacts.paths} paths a pixel`;
}

function tellMeasures(f) {
  $("trace-state").textContent =
    `${f.paths} paths a pixel in ${f.seconds.toFixed(1)} s; the traced picture's own noise: ${(100 * f.relative_noise).toFixed(1)} %`;
  if (!f.measures) return;
  $("measures").hidden = false;
  const rows = f.measures.filter((m) => m.name in measured).map((m) => {
    const row = document.createElement("tr");
    const cells = [measured[m.name], Number(m.value.toPrecision(3))];
    row.append(...cells.map((text) => Object.assign(document.createElement("td"), { textContent: text })));
    row.title = m.definition;
    return row;
  });
  $("measures").tBodies[0].replaceChildren(...rows);
}
