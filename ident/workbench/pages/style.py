"""Look of the page: style sheet, and repairs of what its libraries do."""

from ident.output.figures import theme

CSS = """
h1 { font-size: 1.125rem; font-weight: 500; line-height: 1.5; white-space: nowrap; }
.q-tab__label, .q-btn { text-transform: none !important; letter-spacing: 0; }
.q-btn { min-height: 28px; min-width: 28px; font-size: 14px; }
.q-tooltip { font-size: 12px; background: #333; color: #fff; }
.body--light .nicegui-code { background: #fff; border: 1px solid #8886; }
.command pre, .command code { white-space: pre-wrap; overflow-wrap: anywhere; }
.command pre { padding-right: 44px; }
.picture { max-width: 900px; background: #fff; }
.robot { width: 100% !important; max-width: 760px; }
.modebar-btn, .nicegui-code .q-btn { min-height: 24px; min-width: 24px; font-size: 14px !important; }
.drop-area { position: relative; padding: 12px; text-align: center; }
.drop-area:focus-within { outline: 2px solid #fff; outline-offset: -4px; }
.q-uploader__list { display: none; }
.q-btn--dense { padding: 2px 10px; }
/* STOP must be in reach whatever is asked. */
.q-header { z-index: 7001; }
.q-header .q-btn { flex-shrink: 0; }
.q-tab__label { font-size: 0.95rem; }
.nicegui-content { padding: 0.25rem 1rem; gap: 0; }
.head { font-size: 1.05rem; font-weight: 600; margin: 0.25rem 0; }
.quiet { color: #4f5961; font-size: 0.88rem; }
.body--dark .quiet { color: #b4bdc4; }
.scroll-x { max-width: 100%; overflow-x: auto; }
.figures td, .figures th { padding: 2px 10px; text-align: right; font-variant-numeric: tabular-nums; }
.figures td:first-child, .figures th:first-child { text-align: left; }
.figures th { font-weight: 600; }
.steps tr:last-child td { font-weight: 600; }
.figures td.words, .figures th.words { text-align: left; }
.body--dark .q-btn--outline, .body--dark .q-btn--flat, .body--dark .q-tab { --q-primary: #8cc8f2; }
.q-tab { padding: 0 10px; }
.q-tab__icon { font-size: 20px !important; }
.q-tab.next-step { color: var(--q-primary); font-weight: 600; }
.q-tab.step:not(.last-step)::after { content: "›"; position: absolute; right: -4px; top: 8px; }
.preview { position: sticky; top: 56px; z-index: 5; background: #fff; border-bottom: 1px solid #8886; }
.preview:empty { display: none; }
.candidates { flex-direction: row-reverse; }
.candidates > * { min-width: 0; }
.body--dark .preview { background: #121212; }
.chip { border: 1px solid rgba(128, 128, 128, 0.5); border-radius: 6px; padding: 0 8px; }
.banner { border-left: 4px solid #888; padding: 2px 12px; margin-top: 4px; min-height: 36px; }
.banner-good { border-left: 0; border-radius: 6px; background: #00704f; color: #fff; padding: 6px 12px; }
.banner-good .q-btn--outline, .body--dark .banner-good .q-btn--outline { --q-primary: #fff; }
.nicegui-link { color: #0b5c8c; padding: 4px; }
.body--dark .nicegui-link { color: #8cc8f2; }
.banner-good .nicegui-link, .body--dark .banner-good .nicegui-link { color: #fff; }
.quality { display: grid; grid-template-columns: max-content 1fr max-content 1fr; gap: 0.25rem 1rem; width: 100%; }
.beside { display: flex; gap: 1rem; align-items: flex-start; width: 100%; }
.q-dialog__inner > .import-card { max-width: 900px; width: 900px; }
.dialog-actions { position: sticky; bottom: 0; z-index: 1; padding: 8px 0; background: #fff; }
.body--dark .dialog-actions { background: #1d1d1d; }
.notice { position: fixed; right: 16px; bottom: 16px; z-index: 7000; align-items: center; padding: 4px 16px; }
.notice { border-radius: 4px; background: #323232; color: #fff; }
.q-notification { --q-primary: currentColor; }
:focus-visible { outline: 2px solid var(--q-primary); outline-offset: 2px; }
.chosen-plot { position: relative; margin-top: 44px; }
.plot-chooser { position: absolute; top: -44px; left: 0; right: 0; display: flex; gap: 4px; }
.plot-chooser > * { min-width: 44px; height: 40px; border: 1px solid #8886; border-radius: 6px; color: inherit; }
.plot-chooser > * { background: #fff; }
.body--dark .plot-chooser > * { background: #1d1d1d; }
.plot-chooser select { flex: 1; padding: 0 8px; }
@media (max-width: 800px) {
    .nicegui-content { padding: 0.25rem 0.5rem; }
    h1 { position: absolute; width: 1px; height: 1px; overflow: hidden; }
    .quality { grid-template-columns: max-content 1fr; }
    .beside { flex-wrap: wrap; }
    .preview { position: static; }
    .figures td, .figures th { padding: 2px 4px; }
    .import-card tr { display: flex; flex-wrap: wrap; align-items: center; border-bottom: 1px solid #8886; }
    .import-card th { display: none; }
}
"""

UPLOAD_HEADER = """<div class="drop-area">Drop files here, or press to choose<q-uploader-add-trigger /></div>"""
"""Head of the area for uploads: the input itself can be focused, as no other control lies around it."""

REPAIRS = (
    f"<script>{theme.narrow_javascript()}</script>"
    """<script type="module">
    document.documentElement.lang = "en";

    // NiceGUI resizes a plot whose tab has just been left; Plotly reports that as an error.
    import {Plotly} from "nicegui-plotly";
    const resize = Plotly.Plots.resize;
    Plotly.Plots.resize = plot => plot.offsetParent ? resize(plot) : Promise.resolve(plot);

    // On a narrow page a figure shows one of its plots at a time, which is chosen above it.
    const { narrow, single, belowLegend } = figuresOnNarrowPages;
    const shown = new WeakMap(), chosen = new WeakMap();
    for (const name of ["newPlot", "react"]) {
        const draw = Plotly[name];
        Plotly[name] = (plot, figure, ...others) => {
            shown.set(plot, () => Plotly.react(plot, figure, ...others));
            const one = narrow.matches ? single(figure, chosen.get(plot)) : {names: [], figure};
            const reserve = () => { // NiceGUI sets height
                plot.style.minHeight = plot.layout.height + "px";
                plot.style.maxHeight = narrow.matches ? plot.style.minHeight : "";
            };
            const done = draw(plot, {...one.figure, layout: {...one.figure.layout}}, ...others); // it forgets heights
            offer(plot, one);
            reserve();
            if (!narrow.matches) return done;
            return done.then(() => { if (plot.isConnected) { belowLegend(Plotly, plot); reserve(); } });
        };
    }

    function offer(plot, {names, index}) {
        let chooser = plot.querySelector(".plot-chooser");
        plot.classList.toggle("chosen-plot", names.length > 0);
        if (chooser?.dataset.names !== String(names)) { chooser?.remove(); chooser = null; }
        if (chooser || !names.length) return;
        const select = Object.assign(document.createElement("select"), {ariaLabel: "plot"});
        select.append(...names.map((text, number) => new Option(text, number)));
        select.value = index;
        const show = index => {
            select.value = (index + names.length) % names.length;
            chosen.set(plot, Number(select.value));
            shown.get(plot)();
        };
        select.addEventListener("change", () => show(Number(select.value)));
        const step = (text, ariaLabel, by) => {
            const button = Object.assign(document.createElement("button"), {textContent: text, ariaLabel});
            button.addEventListener("click", () => show(Number(select.value) + by));
            return button;
        };
        chooser = Object.assign(document.createElement("div"), {className: "plot-chooser"});
        chooser.dataset.names = names;
        chooser.append(step("‹", "plot before", -1), select, step("›", "plot after", 1));
        plot.append(chooser);
    }
    narrow.addEventListener("change", () => {
        for (const plot of document.querySelectorAll(".js-plotly-plot")) shown.get(plot)?.();
    });

    // NiceGUI goes on to draw a 3D scene whose tab was left, for ever.
    window.drawOnlyWhileShown = ({$el, renderer, text_renderer, text3d_renderer}) => {
        for (const each of [renderer, text_renderer, text3d_renderer]) {
            const draw = each.render;
            each.render = (...of) => { if ($el.isConnected) draw.apply(each, of); };
        }
    };

    // Back, in the browser, leads to the tab before.
    window.noteTab = tab => {
        const before = history.state?.tab;
        if (tab !== before) history[before ? "pushState" : "replaceState"]({tab}, "");
    };
    addEventListener("popstate", event => { if (event.state?.tab) emitEvent("went_back", event.state.tab); });

    // Quasar's input for files has no name and cannot be reached with the keyboard.
    new MutationObserver(() => {
        for (const input of document.querySelectorAll(".q-uploader__input:not([aria-label])")) {
            input.setAttribute("aria-label", "Files to add");
            input.tabIndex = 0;
        }
    }).observe(document.body, {childList: true, subtree: true});
</script>"""
)
