//! The baked scene that pages show, and the view that they start with.

use crate::ask::Ask;
use crate::own::{OwnLights, sun_rows};
use rrf_field::{Borders, Field};
use rrf_lights::DistantLight;
use rrf_render::{Lights, Renderer, Surroundings, Trusted, View};
use rrf_scene::PointLight;
use rrf_trace::Tracer;
use rrf_transfer::LightBook;
use serde_json::{Value, json};

/// What answers for a scene's indirect light.
#[derive(Clone, Copy)]
pub enum ShownModel<'a> {
    /// Nets that see point lights.
    Nets(&'a Field),
    /// A transfer, which keeps the lights that it knows: one that moves is asked for alone.
    Transfer(&'a LightBook<'a>),
}

/// A baked scene to look at.
#[derive(Clone)]
pub struct Show<'a> {
    /// The scene as baked, without its own lights, and the boxes that it was baked for.
    pub surroundings: Surroundings<'a>,
    /// What answers for its indirect light.
    pub model: ShownModel<'a>,
    /// Whether mirrors, glass and other narrow lobes are traced, since the model does not know them.
    pub traces_narrow: bool,
    /// Borders of its cells, where they can be blended.
    pub borders: Option<&'a Borders>,
    /// Which rows nets were trained for.
    pub trusted: &'a Trusted<'a>,
    /// The view that a page starts with.
    pub view: View,
    /// Whether that view was typed: it is not the scene's own.
    pub view_is_typed: bool,
    /// The lights that it starts with, beside the scene's own.
    pub lights: Vec<PointLight>,
    /// The suns that it starts with.
    pub suns: Vec<DistantLight>,
    /// The scene's own lights.
    pub own: OwnLights<'a>,
    /// The run folder, as the equivalent command names it.
    pub run: String,
    /// Whether to give up what is being made.
    pub halt: &'a (dyn Fn() -> bool + Sync),
}

impl<'a> Show<'a> {
    /// The tracer of the scene with its lamps, where they shine, or without.
    pub fn tracer(&self, lamps: bool) -> &'a Tracer<'a> {
        match lamps {
            true => self.own.tracer,
            false => self.surroundings.tracer,
        }
    }

    /// Renderers for one viewer, without lamps and with them.
    pub fn renderers(&self) -> [Renderer<'a>; 2] {
        [false, true].map(|lamps| {
            let renderer = match self.model {
                ShownModel::Nets(field) => Renderer::new(self.tracer(lamps), field),
                ShownModel::Transfer(book) => Renderer::of_transfer(self.tracer(lamps), book),
            };
            renderer.tracing_narrow(self.traces_narrow)
        })
    }

    /// Facts that a page needs before its first question.
    pub fn hello(&self) -> Value {
        let (view, scene) = (&self.view, self.surroundings.tracer.scene());
        let bounds = scene.bounds();
        let [low, high] = bounds.map_or([[0.0; 3], [1.0; 3]], |b| [b.min, b.max]);
        let light = |l: &PointLight| [l.position.to_array(), l.intensity.to_array()].concat();
        json!({
            "run": self.run,
            "eye": view.eye.to_array(),
            "right": view.right.to_array(),
            "up": view.up.to_array(),
            "forward": view.forward.to_array(),
            "fov": view.fov,
            "view_is_typed": self.view_is_typed,
            "size": [view.width, view.height],
            "lights": self.lights.iter().map(light).collect::<Vec<_>>(),
            "suns": sun_rows(&self.suns),
            "own": self.own.rows(),
            "own_on": self.own.on,
            "blends": self.borders.is_some(),
            "light_box": self.surroundings.light_box.map(|corner| corner.to_array()),
            "bounds": [low, high],
            "cells": match self.model {
                ShownModel::Nets(field) => field.models().len(),
                ShownModel::Transfer(book) => book.model().cells.len(),
            },
            "triangles": scene.triangles.len(),
        })
    }

    /// Warnings about a view and its lights.
    pub fn warnings(&self, ask: &Ask, lights: &Lights) -> Vec<String> {
        let positions = lights.points.iter().map(|light| light.position);
        let warnings = self
            .surroundings
            .warnings(ask.view(&self.view).eye, positions);
        let mut told: Vec<String> = warnings.into_iter().map(|w| w.message).collect();
        if !(self.own.known || lights.sources.is_empty()) {
            let mut names: Vec<&str> = lights.sources.iter().map(|l| l.name.as_str()).collect();
            names.dedup();
            told.push(format!(
                "{}: these nets know point lights, so that the indirect light of others is missing",
                names.join(", ")
            ));
        }
        told
    }
}
