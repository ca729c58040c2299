for (const player of document.querySelectorAll(".player")) {
  const frames = JSON.parse(player.querySelector("script").textContent);
  const [object, track, estimate, force] =
    [".moving", ".track", ".estimate-marks", ".force"].map(name => player.querySelector(name));
  const [controls, button, slider, output] =
    [".controls", "button", "input", "output"].map(name => player.querySelector(name));
  const end = frames.poses.length - 1;
  let timer = 0;
  const show = index => {
    const [x, y, turn] = frames.poses[index];
    object.setAttribute("transform", `translate(${x} ${y}) rotate(${turn})`);
    track.setAttribute("points", frames.poses.slice(0, index + 1).map(([x, y]) => `${x},${y}`).join(" "));
    force.setAttribute("d", frames.forces[index]);
    estimate.innerHTML = frames.estimates.filter(([start]) => start <= index).pop()[1];
    output.textContent = frames.texts[index];
    slider.value = index;
    slider.setAttribute("aria-valuetext", frames.texts[index]);
  };
  const stop = () => {
    clearInterval(timer);
    timer = 0;
    button.textContent = "Play";
  };
  const step = () => {
    const index = Number(slider.value);
    index < end ? show(index + 1) : stop();
  };
  button.addEventListener("click", () => {
    if (timer) return stop();
    if (Number(slider.value) >= end) show(0);
    timer = setInterval(step, 1000 * frames.period);
    button.textContent = "Pause";
  });
  slider.addEventListener("input", () => {
    stop();
    show(Number(slider.value));
  });
  addEventListener("beforeprint", () => {
    stop();
    show(end);
  });
  controls.hidden = false;
}
