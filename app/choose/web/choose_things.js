// The contact sheet of the objects.

/** By id: the view that shows most of it, how many pixels that is, and the box that holds them. */
function placesOfThings() {
  const best = new Map();
  for (const view of data.views) {
    const here = new Map();
    for (let y = 0, p = 0; y < view.height; ++y)
      for (let x = 0; x < view.width; ++x, ++p) {
        if (!here.has(view.id[p])) here.set(view.id[p], {view, pixels: 0, low: [x, y], high: [x, y]});
        const place = here.get(view.id[p]);
        ++place.pixels;
        place.low = [Math.min(place.low[0], x), place.low[1]];
        place.high = [Math.max(place.high[0], x), y];
      }
    for (const [id, place] of here) if (!(best.get(id)?.pixels >= place.pixels)) best.set(id, place);
  }
  return best;
}

function listThings() {
  const places = placesOfThings();
  element('things').replaceChildren(...data.things.map((thing) => rowOf(thing, places.get(thing.id))));
}

/** A row of the contact sheet; choosing it shows the object where the present view does not. */
function rowOf(thing, place) {
  const label = document.createElement('label');
  label.className = 'thing';
  const input = Object.assign(document.createElement('input'), {type: 'radio', name: 'thing', value: thing.id});
  input.onchange = () => {
    if (place && !data.views[at].id.includes(thing.id)) turn(data.views.indexOf(place.view) - at);
    choose(thing.id);
  };
  const crop = Object.assign(document.createElement('canvas'), {width: 112, height: 112});
  crop.style.borderColor = `rgb(${thing.color.map((c) => 255 * c)})`;
  if (place) place.view.image.decode().then(() => drawCrop(crop, thing.id, place));
  const name = document.createElement('span');
  const count = document.createElement('small');
  count.textContent = `${thing.gaussians.toLocaleString('en')} Gaussians`;
  name.append(thing.name, count);
  label.append(input, crop, name);
  return label;
}

/** What a view shows of an object, with a margin; what is around it is darkened. */
function drawCrop(crop, id, {view, low, high}) {
  const side = 1.2 * Math.max(high[0] - low[0] + 1, high[1] - low[1] + 1);
  const corner = [0, 1].map((a) => (low[a] + high[a] + 1 - side) / 2);
  const shade = new ImageData(view.width, view.height);
  for (let p = 0; p < view.id.length; ++p) shade.data[4 * p + 3] = view.id[p] === id ? 0 : 150;
  for (const layer of [view.image, sheetOf(shade)])
    crop.getContext('2d').drawImage(layer, ...corner, side, side, 0, 0, crop.width, crop.height);
}

listThings();
