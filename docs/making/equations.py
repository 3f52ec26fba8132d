# ruff: noqa: E501
"""The equations of the laws as the pages print them, in LaTeX, and their symbols. `Definition.equation` is the same as text."""

from typing import NamedTuple


class Equation(NamedTuple):
    """Of one law."""

    lines: tuple  # LaTeX
    symbols: str  # in the order in which they come; a page explains them by `making.symbols`


EQUATIONS = {
    "hertz": Equation(
        (r"P = (4/3) E^{*} \sqrt{R} \delta^{1.5}",),
        "P E* R δ",
    ),
    "rms": Equation(
        (
            r"\delta = a^{* 2}/R",
            r"a^{*}/a_{H} = 2.4 - 2.8/(\alpha + 2)",
        ),
        "δ a* R a_H α",
    ),
    "pohrt-popov": Equation(
        (
            r"K = (\pi \sqrt{A_{0}} E^{*} D_{f}/10) (P/(\sigma E^{*} \sqrt{A_{0}}))^{0.2567 D_{f}} \ \text{to}\ F, \ \text{then Hertz stiffness}",
        ),
        "K A0 E* Df P σ F",
    ),
    "goddard": Equation(
        (
            r"P = (2E^{*}/(\pi \operatorname{tan} \beta)) \delta^{2} \ \text{to}\ P^{*} = (9\pi^{3}/128) E^{*} R^{2} \operatorname{tan}^{3}\beta, \ \text{then Hertz stiffness}",
        ),
        "P E* β δ P* R",
    ),
    "rough-plastic": Equation(
        (r"K = \operatorname{min}(K_{\mathrm{rough}}(P), \pi R p_{y})",),
        "K K_rough P R p_y",
    ),
    "bahrami": Equation(
        (
            r"\delta /\delta_{H} = a_{L}'^{2}/2 + 8 p_{0}' a_{L}'/(\pi^{2}(4.79 - 3.17 p_{0}'^{3.13}))",
            r"p_{0}' = 1/(1 + 1.22 \alpha \kappa^{-0.16})",
        ),
        "δ δ_H a_L' p0' α κ",
    ),
    "yip-venart": Equation(
        (
            r"s(r) = d + r^{2} + w(r) - w(0)",
            r"p = H_{m} \tfrac{1}{2} \operatorname{erfc}(s/\sqrt{2}), w \ \text{from the elastic half-space}",
        ),
        "s r d w p H_m",
    ),
    "greenwood-tripp": Equation(
        (
            r"s(r) = d + r^{2} + w(r) - w(0)",
            r"p = (\mu /2) E^{*} \sqrt{\sigma /2R} F_{3/2}(s), w \ \text{from the elastic half-space}",
        ),
        "s r d w p μ E* σ R F_3/2",
    ),
    "asperity": Equation(
        (
            r"P = \Sigma \ \text{elastic-plastic ellipsoids}, \ \text{one per contact patch of the cut height map}, \ \text{with its area and volume}",
        ),
        "P",
    ),
    "thornton-ning": Equation(
        (
            r"P = (4/3) E^{*} \sqrt{R} \delta^{1.5} \ \text{to}\ p_{y}",
            r"\text{then}\ \mathrm{d}P/\mathrm{d}\delta = \pi R p_{y}, \ \text{back along Hertz's curve of}\ R_{p}",
        ),
        "P E* R δ p_y R_p",
    ),
    "jackson-green": Equation(
        (
            r"P/P_{c} = \operatorname{exp}(-\omega^{5/12}/4) \omega^{1.5} + (4 H_{G}/(C S_{y})) (1 - \operatorname{exp}(-\omega^{5/9}/25)) \omega, \ \text{Hertz below}",
            r"\omega = \delta /\omega_{c}",
        ),
        "P P_c ω H_G C S_y δ ω_c",
    ),
    "kogut-etsion": Equation(
        (
            r"P/P_{c} = \operatorname{min}(\omega^{1.5}, 1.03 \omega^{1.425}, 1.40 \omega^{1.263})",
            r"\omega = \delta /\omega_{c}",
            r"\omega_{c} = (\pi K H/(2E^{*}))^{2} R",
        ),
        "P P_c ω δ ω_c K H E* R",
    ),
    "conical-damage": Equation(
        (
            r"\text{Hertz to}\ p_{0} = \sigma_{\mathrm{max}}",
            r"\text{then}\ p_{0} = \sigma_{\mathrm{max}}: R = (\delta + R_{0} A)/(h + A)",
            r"P = (4/3) E^{*} h^{1.5} R^{2}",
        ),
        "p0 σ_max R δ R0 A h P E*",
    ),
    "walton-braun": Equation(
        (
            r"P = k_{1} \delta, \ \text{back along}\ k_{2} (\delta - \delta_{p})",
            r"k_{2} \ \text{constant or}\ k_{2} = k_{1} + S P_{\mathrm{max}}",
        ),
        "P k1 δ k2 δp S Pmax",
    ),
    "luding": Equation(
        (
            r"P = k_{1} \delta \ \text{to}\ \delta^{*}, \ \text{then}\ \hat{k}_{2}, \ \text{back along}\ k_{2} (\delta - \delta_{p})",
            r"k_{2} = k_{1} + (\hat{k}_{2} - k_{1}) \delta_{\mathrm{max}}/\delta^{*}",
        ),
        "P k1 δ δ* k̂2 k2 δp δmax",
    ),
    "eepa": Equation(
        (
            r"P = k_{1} \delta^{1.5}, \ \text{back along}\ k_{2} (\delta^{1.5} - \delta_{p}^{1.5})",
            r"\delta_{p} = (1 - k_{1}/k_{2})^{2/3} \delta_{\mathrm{max}}",
        ),
        "P k1 δ k2 δp δmax",
    ),
}
