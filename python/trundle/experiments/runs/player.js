"use strict";
for (const player of document.querySelectorAll(".player")) {
  const told = JSON.parse(player.querySelector("script").textContent);
  const [moving, way, belief, force] = [".moving", ".way", ".belief", ".force"].map(name => player.querySelector(name));
  const [controls, button, slider, output] =
    [".controls", "button", "input", "output"].map(name => player.querySelector(name));
  const end = told.poses.length - 1;
  let timer = 0;
  const show = index => {
    const [x, y, turn] = told.poses[index];
    moving.setAttribute("transform", `translate(${x} ${y}) rotate(${turn})`);
    way.setAttribute("points", told.way.slice(0, index + 1).join(" "));
    force.setAttribute("d", told.force[index]);
    belief.innerHTML = told.beliefs.filter(([start]) => start <= index).pop()[1];
    output.textContent = told.said[index];
    slider.value = index;
    slider.setAttribute("aria-valuetext", told.said[index]);
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
    timer = setInterval(step, 1000 * told.period);
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
